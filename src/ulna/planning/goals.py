"""Finds the configurations that a plan may end in.

Several links, such as both hands of a robot, may have a pose each. Each link has joints of its own, which move it and no other of
these links: those of its arm. Joints that move several of them, such as those of a torso, keep their positions. So the inverse
kinematics of each link is a problem of its own, and every choice of one solution for each link is a solution for all. Which of
these choices are free is decided for the whole robot at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.ik.options import Options
from ulna.ik.reason import NO_REASON, Reason
from ulna.ik.result import IKResult, Status
from ulna.kinematics.sample import random_positions
from ulna.planning.plan_status import PlanStatus
from ulna.planning.request import Request, joint_of, own_columns

Array = NDArray[np.float64]
SPREAD = 16  # configurations for a pose of a redundant arm, or places of the joint that its closed form holds
_SEEDS = 16  # from which a pose is searched with joints held
_FIRST_CHOICES, _MOST_CHOICES = 1024, 65536  # of one solution for each link, that are tested
_MOST_GOALS = 32  # nearest to the start


class Goals(NamedTuple):
    """Configurations that a plan may end in.

    Attributes:
        q: The free ones, shape (n, n_dof).
        of: Which of the goals given each belongs to, shape (n,).
        status: If there is none, why.
        reason: The same in words, with the report or the result that shows it.
    """

    q: Array
    of: NDArray[np.int64]
    status: PlanStatus = PlanStatus.SOLVED
    reason: Reason = NO_REASON


def find_goals(request: Request, goal: Array, fixed: NDArray[np.bool_], free: NDArray[np.bool_]) -> Goals:
    """The free configurations of a goal; or why there is none.

    fixed: the entries of q that keep their positions, shape (n_dof,); free: which of the configurations given are, shape (n,).

    Raises:
        InputError: A configuration moves a joint that keeps its position.
    """
    if goal.ndim == 3:
        return _of_poses(request, goal, fixed)
    if fixed.any() and (moved := (goal != request.start) & fixed).any():
        row, k = np.argwhere(moved)[0]
        way = f"joint {joint_of(k, request.tree)!r} is to go from {request.start[k]:.6g} to {goal[row, k]:.6g}"
        raise InputError("goal", f"{way}, but it keeps its position: it is held, or outside the group")
    if free.all():
        return Goals(goal, np.arange(len(goal)))  # the most frequent case
    if free.any():
        return Goals(goal[free], np.flatnonzero(free))
    return Goals(goal[:0], np.empty(0, dtype=np.int64), PlanStatus.GOAL_IN_COLLISION, request.collision(goal[0]))


def _of_poses(request: Request, poses: Array, fixed: NDArray[np.bool_]) -> Goals:
    rows, of = [], []
    for i, T in enumerate(poses):
        found = solutions_of(request, T, fixed)
        found[:, fixed] = request.start[fixed]
        found = found[request.is_free(found)] if len(found) else found
        rows.append(found)
        of.append(np.full(len(found), i))
    q = np.concatenate(rows)
    if len(q):
        return Goals(q, np.concatenate(of))
    return _why_none(request, poses[0], q)


def solutions_of(request: Request, T: Array, fixed: NDArray[np.bool_]) -> Array:
    """All configurations found for a pose that are clear of the world, shape (n, n_dof); ``fixed`` entries may be anything."""
    link = request.tree.link_or_tip(request.link)
    if fixed[request.tree.moving_columns(link)].any():
        n = request.tree.n_dof
        seeds = np.vstack([request.start, random_positions(request.tree, _SEEDS - 1, request.seed)])
        seeds[:, fixed] = request.start[fixed]
        result = solve(request, np.broadcast_to(T, (_SEEDS, 4, 4)).copy(), seeds)
        return np.unique(result.q[result.success].reshape(-1, n), axis=0)
    found = request.inverse_kinematics.all_solutions(
        T, request.start, None, link, Options(seed=request.seed, task=request.task, threads=1), n_samples=SPREAD
    )
    return found.q[found.valid]


def solve(request: Request, T: Array, seeds: Array) -> IKResult:
    """A search for each of several poses, or for one, from seeds in which the joints are held as the request says."""
    search = request.inverse_kinematics.inverse_kinematics
    options = Options(seed=request.seed, task=request.task)
    return search(T, seeds, None, request.held, request.world, request.link, options)


def _why_none(request: Request, T: Array, none: Array) -> Goals:
    """What inverse kinematics says of a pose for which no free configuration was found."""
    result, of_none = solve(request, T, request.start), np.empty(0, dtype=np.int64)
    if result.success and request.is_free(result.q[None])[0]:
        return Goals(result.q[None].copy(), np.zeros(1, dtype=np.int64))
    if result.success or result.status == Status.IN_COLLISION:
        return Goals(none, of_none, PlanStatus.GOAL_IN_COLLISION, request.collision(result.q))
    return Goals(none, of_none, PlanStatus.GOAL_UNREACHABLE, Reason(str(result), result))


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
