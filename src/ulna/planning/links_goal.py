"""Finds the configurations that bring several links to a pose each, such as both hands of a robot.

Each link has joints of its own, which move it and no other of these links: those of its arm. Joints that move several of
them, such as those of a torso, are held. So the inverse kinematics of each link is a problem of its own, and every choice of
one solution for each link is a solution for all. Which of these choices are free is decided for the whole robot at once.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.errors import InputError, UnknownNameError
from ulna.ik.reason import Reason
from ulna.ik.result import IKResult
from ulna.kinematics.tree import Tree
from ulna.planning.goals import Goals, Request, solutions_of, solve
from ulna.planning.plan_status import PlanStatus

Array = NDArray[np.float64]
_FIRST_CHOICES, _MOST_CHOICES = 1024, 65536  # of one solution for each link, that are tested
_MOST_GOALS = 32  # nearest to the start


def as_links_goal(goal: Mapping[str, ArrayLike], tree: Tree) -> dict[str, Array]:
    """A pose for each of several links, shape (4, 4) each.

    Raises:
        InputError: No link is named, a pose is not a rigid motion, or a link has no joints of its own.
        UnknownNameError: There is no such link.
    """
    if not goal:
        raise InputError("goal", "no link is named; a pose for each of some links is expected")
    poses = {}
    for link, T in goal.items():
        if link not in tree.link_names:
            raise UnknownNameError("link", str(link), tree.link_names)
        poses[link] = as_floats("goal", T)
        if poses[link].shape != (4, 4):
            raise InputError("goal", f"shape {poses[link].shape} for link {link!r}; one pose, shape (4, 4), is expected")
        as_pose(poses[link])
    for link, columns in own_columns(poses, tree).items():
        if not columns.any():
            raise InputError("goal", f"no joint moves link {link!r} that does not move another link of the goal")
    return poses


def own_columns(links: Mapping[str, object], tree: Tree) -> dict[str, NDArray[np.bool_]]:
    """By link: the entries of q that move it and none of the others, shape (n_dof,) each."""
    moves = np.zeros((len(links), tree.n_dof), dtype=bool)
    for row, link in zip(moves, links, strict=True):
        row[tree.moving_columns(link)] = True
    return dict(zip(links, moves & (moves.sum(axis=0) == 1), strict=True))


def fixed_for_links(poses: Mapping[str, Array], tree: Tree) -> NDArray[np.bool_]:
    """The entries of q that move none of the links, or several, shape (n_dof,)."""
    return ~np.logical_or.reduce(list(own_columns(poses, tree).values()))


def find_links_goals(request: Request, poses: Mapping[str, Array], fixed: NDArray[np.bool_]) -> Goals:
    """The free configurations in which each link is at its pose, nearest to the start first. If there are none, the reason.

    fixed: the entries of q that keep their positions, shape (n_dof,).
    """
    tree, none, of_none = request.tree, np.empty((0, request.tree.n_dof)), np.empty(0, dtype=np.int64)
    slices = zip(tree.joint_names, tree.joint_slices, strict=True)
    alone = request._replace(world=None, held=tuple(name for name, part in slices if fixed[part].any()))
    own, each = own_columns(poses, tree), {}
    for link, T in poses.items():
        found = _of_link(alone._replace(link=link), T, fixed | ~own[link])
        if isinstance(found, IKResult):
            return Goals(none, of_none, PlanStatus.GOAL_UNREACHABLE, Reason(f"{link}: {found}", found))
        each[link] = _nearest_first(found, request.start, own[link])
    q = none
    for most in (_FIRST_CHOICES, _MOST_CHOICES):  # the nearest of each link, and more only where none of these is free
        q = _choices(each, own, request.start, max(1, int(most ** (1 / len(poses)) + 1e-9)))
        free = q[request.is_free(q)]
        if len(free):
            free = _nearest_first(free, request.start, ~fixed)[:_MOST_GOALS]
            return Goals(free, np.zeros(len(free), dtype=np.int64))
    return Goals(none, of_none, PlanStatus.GOAL_IN_COLLISION, request.collision(q[0]))


def _choices(each: Mapping[str, Array], own: Mapping[str, NDArray[np.bool_]], start: Array, n_each: int) -> Array:
    """Every choice of one of the first solutions of each link, shape (n, n_dof); all else is as at the start."""
    choices = list(product(*(found[:n_each] for found in each.values())))
    q = np.tile(start, (len(choices), 1))
    for row, choice in zip(q, choices, strict=True):
        for link, solution in zip(each, choice, strict=True):
            row[own[link]] = solution[own[link]]
    return q


def _nearest_first(q: Array, start: Array, columns: NDArray[np.bool_]) -> Array:
    return q[np.argsort(np.linalg.norm((q - start)[:, columns], axis=1), kind="stable")]


def _of_link(request: Request, T: Array, fixed: NDArray[np.bool_]) -> Array | IKResult:
    """The configurations in which a link is at a pose, collisions ignored, shape (n, n_dof); or the failed search."""
    found = solutions_of(request, T, fixed)
    if len(found):
        return found
    result = solve(request, T, request.start)
    return result.q[None] if result.success else result
