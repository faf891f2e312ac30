"""Finds the goal configurations of a plan.

For a goal with several links, inverse kinematics is solved for each link separately. Every combination of one solution per link
is a candidate. The whole robot is then checked for collisions in each candidate.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.clouds import PointCloud
from ulna.collision.report import Pair, Report
from ulna.collision.world import World
from ulna.dynamics.dynamics import Dynamics
from ulna.errors import InputError, count_of
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import Options
from ulna.ik.options import Request as IKRequest
from ulna.ik.reason import Reason
from ulna.ik.result import IKResult, Status
from ulna.ik.task import Task
from ulna.kernels.planning.constraint_records import Constraints
from ulna.kinematics.forward import forward_kinematics
from ulna.kinematics.sample import random_positions
from ulna.kinematics.tree import Tree
from ulna.planning.keep import Keep
from ulna.planning.plan import Plan, PlanStatus, no_plan
from ulna.planning.space import same_entries
from ulna.planning.targets import Targets, joint_name, own_columns

Array = NDArray[np.float64]
N_SAMPLES_PER_POSE = 16  # configurations per pose of a redundant arm, or positions of the joint that its closed form holds
_SEEDS = 16  # seeds of a numeric search for a pose with held joints
_FIRST_CHOICES, _MAX_CHOICES = 1024, 65536  # combinations of one solution per link: first round, second round
_MAX_GOALS = 32  # combinations that become goals, nearest to the start
_MAX_PAIRS = 4  # colliding pairs named in a message


class Goals(NamedTuple):
    """Free goal configurations, at least one.

    Attributes:
        q: The configurations, shape (n, n_dof).
        goal_index: The index of the given goal that each configuration solves, shape (n,).
    """

    q: Array
    goal_index: NDArray[np.int64]


class Request(NamedTuple):
    """A checked planning problem without its goal.

    Attributes:
        tree: The robot's kinematic tree.
        checker: Checks configurations for collisions.
        inverse_kinematics: Solves for the configurations of a pose.
        world: The obstacles, if any.
        margin: The minimum distance from obstacles [m].
        start: The start configuration, shape (n_dof,).
        held: The names of the joints that keep their positions.
        task: The components of a pose that count.
        seed: Seed of the search for a pose.
        fixed: The entries of q that keep their positions, shape (n_dof,).
        keeps: The constraints.
        constraints: The constraints for the kernels; None without constraints.
        search_constraints: ``constraints`` with slightly smaller tolerances.
        relative_poses: By link: the pose relative to the goal's link of each link that a constraint ties to it; see
            ``relative_goal_poses``.
        dynamics: The dynamics of the robot.
        spread: The number of configurations to compute for a pose.
    """

    tree: Tree
    checker: Checker
    inverse_kinematics: InverseKinematics
    world: World | None
    margin: float
    start: Array
    held: tuple[str, ...]
    task: Task | str
    seed: int
    fixed: NDArray[np.bool_]
    keeps: tuple[Keep, ...]
    constraints: Constraints | None
    search_constraints: Constraints | None
    relative_poses: Mapping[str, Array]
    dynamics: Dynamics
    spread: int = N_SAMPLES_PER_POSE

    def is_free(self, q: Array) -> NDArray[np.bool_]:
        """Mask of the configurations, shape (n, n_dof), that touch nothing and keep the margin from the world."""
        return is_free(self.checker, q, self.world, self.margin)

    def touching(self, q: Array) -> tuple[Pair, ...]:
        """The pairs that touch at q, and the pairs with an obstacle nearer than the margin."""
        near = self.checker.check_collision(q, self.world, self_collision=True, max_distance=self.margin)
        return tuple(pair for pair in near.pairs if pair.link_b is None or pair.signed_distance <= 0.0)

    def collision(self, q: Array) -> Reason:
        """The pairs of ``touching`` in words, with a remedy; the data is their ``Report``."""
        pairs, world = self.touching(q), self.world
        own = all(pair.link_b is not None for pair in pairs)
        hint = "; if these shapes touch in every configuration, allow the pairs (docs/self_collision.md)" if own else ""
        shapes = {} if world is None else {name: shape for name, shape, _ in world.items()}
        for name in dict.fromkeys(pair.name_b for pair in pairs if pair.link_b is None):
            if isinstance(shapes.get(name), PointCloud):
                hint += f"; {name} is a point cloud: if its points are on the robot itself, cloud.without(robot, q) removes them"
        more = f" and {count_of(len(pairs) - _MAX_PAIRS, 'more pair')}" if len(pairs) > _MAX_PAIRS else ""
        words = ", ".join(_describe_pair(pair, self.margin) for pair in pairs[:_MAX_PAIRS])
        return Reason(words + more + hint, Report(pairs))


def is_free(checker: Checker, q: Array, world: World | None, margin: float) -> NDArray[np.bool_]:
    """Mask of the configurations, shape (n, n_dof), that touch nothing and keep a margin from the world."""
    free = np.logical_not(checker.in_collision(q, world, self_collision=True))
    if margin > 0.0 and world is not None and world.names:
        free &= checker.signed_distance(q, world, self_collision=False) > margin
    return free


def _describe_pair(pair: Pair, margin: float) -> str:
    distance = pair.signed_distance * 1e3
    if distance > 0.0:
        return f"{pair.name_a} is {distance:.3g} mm from {pair.name_b}, nearer than {margin * 1e3:.3g} mm"
    return (
        f"{pair.name_a} and {pair.name_b} ({-distance:.3g} mm deep)" if distance < 0.0 else f"{pair.name_a} touches {pair.name_b}"
    )


def free_goals(request: Request, targets: Targets, free: NDArray[np.bool_]) -> Goals | Plan:
    """The free configurations of a goal, or a failed plan with the reason if there are none.

    free: mask of the given configurations that are free, shape (n,).

    Raises:
        InputError: A goal configuration moves a joint that keeps its position.
    """
    if isinstance(targets, np.ndarray):
        return _configuration_goals(request, targets, free)
    link, T = next(iter(targets.items()))
    if T.ndim == 2:
        return _link_goals(request, targets)
    return _pose_goals(request, link, T) if len(targets) == 1 else _alternative_goals(request, targets)


def _configuration_goals(request: Request, q: Array, free: NDArray[np.bool_]) -> Goals | Plan:
    fixed = request.fixed
    if fixed.any() and (moved := ~same_entries(request.tree, request.start, q) & fixed).any():
        row, k = np.argwhere(moved)[0]
        way = f"joint {joint_name(k, request.tree)!r} would move from {request.start[k]:.6g} to {q[row, k]:.6g}"
        raise InputError("goal", f"{way}, but it is held, or outside the group")
    if free.all():
        return Goals(q, np.arange(len(q)))  # the most frequent case
    if free.any():
        return Goals(q[free], np.flatnonzero(free))
    return no_plan(request.tree, PlanStatus.GOAL_IN_COLLISION, request.collision(q[0]))


def _pose_goals(request: Request, link: str, poses: Array) -> Goals | Plan:
    """The free configurations in which a link is at one of several poses, shape (n, 4, 4)."""
    rows, goal_index, fixed = [], [], request.fixed
    for i, T in enumerate(poses):
        found = _find_solutions(request, link, T, fixed)
        found[:, fixed] = request.start[fixed]
        found = found[request.is_free(found)] if len(found) else found
        rows.append(found)
        goal_index.append(np.full(len(found), i))
    q = np.concatenate(rows)
    if len(q):
        return Goals(q, np.concatenate(goal_index))
    result = _solve(request, link, poses[0], request.start)
    if result.success and request.is_free(result.q[None])[0]:
        return Goals(result.q[None].copy(), np.zeros(1, dtype=np.int64))
    if result.success or result.status == Status.IN_COLLISION:
        return no_plan(request.tree, PlanStatus.GOAL_IN_COLLISION, request.collision(result.q))
    return no_plan(request.tree, PlanStatus.GOAL_UNREACHABLE, Reason(_ik_reason(result), result))


def _link_goals(request: Request, poses: Mapping[str, Array]) -> Goals | Plan:
    """The free configurations in which each link is at its pose, shape (4, 4), nearest to the start first."""
    tree, fixed = request.tree, request.fixed
    alone, own, each = _single_link_request(request), own_columns(poses, tree), {}
    for link, T in poses.items():
        found = _find_solutions(alone, link, T, fixed | ~own[link])
        if not len(found):
            result = _solve(alone, link, T, request.start)
            if not result.success:
                return no_plan(tree, PlanStatus.GOAL_UNREACHABLE, Reason(f"{link}: {_ik_reason(result)}", result))
            found = result.q[None]
        each[link] = _sort_by_distance(found, request.start, own[link])
    q = request.start[None]
    for most in (_FIRST_CHOICES, _MAX_CHOICES):  # the nearest solutions of each link first; more if none of these is free
        q = _combine_solutions(each, own, request.start, max(1, int(most ** (1 / len(poses)) + 1e-9)))
        free = q[request.is_free(q)]
        if len(free):
            free = _sort_by_distance(free, request.start, ~fixed)[:_MAX_GOALS]
            return Goals(free, np.zeros(len(free), dtype=np.int64))
    return no_plan(tree, PlanStatus.GOAL_IN_COLLISION, request.collision(q[0]))


def _ik_reason(result: IKResult) -> str:
    """The reason of failed inverse kinematics, without the leading status."""
    return str(result).removeprefix(f"{Status.UNREACHABLE}: ")


def _alternative_goals(request: Request, targets: Mapping[str, Array]) -> Goals | Plan:
    """The free configurations for alternative goals: each row has one pose per link, shape (n, 4, 4) each."""
    found = [_link_goals(request, dict(zip(targets, poses, strict=True))) for poses in zip(*targets.values(), strict=True)]
    goals = {i: each.q for i, each in enumerate(found) if isinstance(each, Goals)}
    if not goals:
        return found[0]
    return Goals(np.concatenate(list(goals.values())), np.repeat(list(goals), [len(q) for q in goals.values()]))


def reached_poses(request: Request, poses: Mapping[str, Array], link: str, most: int) -> Array:
    """The poses of one of several links, shape (n, 4, 4), in the task's solutions nearest to the start."""
    own = own_columns(poses, request.tree)[link]
    found = _find_solutions(_single_link_request(request), link, poses[link], request.fixed | ~own)
    return forward_kinematics(request.tree, _sort_by_distance(found, request.start, own)[:most], link)


def _single_link_request(request: Request) -> Request:
    """The request for one of several links, without a world and with all fixed joints held."""
    slices = zip(request.tree.joint_names, request.tree.joint_slices, strict=True)
    return request._replace(world=None, held=tuple(name for name, part in slices if request.fixed[part].any()))


def _combine_solutions(each: Mapping[str, Array], own: Mapping[str, NDArray[np.bool_]], start: Array, n_each: int) -> Array:
    """All combinations of the first ``n_each`` solutions of each link, shape (n, n_dof); other entries are the start's."""
    choices = list(product(*(found[:n_each] for found in each.values())))
    q = np.tile(start, (len(choices), 1))
    for row, choice in zip(q, choices, strict=True):
        for link, solution in zip(each, choice, strict=True):
            row[own[link]] = solution[own[link]]
    return q


def _sort_by_distance(q: Array, start: Array, columns: NDArray[np.bool_]) -> Array:
    return q[np.argsort(np.linalg.norm((q - start)[:, columns], axis=1), kind="stable")]


def _find_solutions(request: Request, link: str, T: Array, fixed: NDArray[np.bool_]) -> Array:
    """All configurations found for a pose of a link, shape (n, n_dof); ``fixed`` entries are arbitrary."""
    if fixed[request.tree.moving_columns(link)].any():
        n = request.tree.n_dof
        seeds = np.vstack([request.start, random_positions(request.tree, _SEEDS - 1, request.seed)])
        seeds[:, fixed] = request.start[fixed]
        result = _solve(request, link, np.broadcast_to(T, (_SEEDS, 4, 4)).copy(), seeds)
        return np.unique(result.q[result.success].reshape(-1, n), axis=0)
    options = Options(seed=request.seed, task=request.task)
    asked = IKRequest(T, request.start, link=link, options=options)
    found = request.inverse_kinematics.all_solutions(asked, n_samples=request.spread)
    return found.q[found.valid]


def _solve(request: Request, link: str, T: Array, seeds: Array) -> IKResult:
    """Solve inverse kinematics for one pose or several, from seeds, with the joints of ``request.held`` held."""
    options = Options(seed=request.seed, task=request.task)
    asked = IKRequest(T, seeds, held=request.held, world=request.world, link=link, options=options)
    return request.inverse_kinematics.inverse_kinematics(asked)
