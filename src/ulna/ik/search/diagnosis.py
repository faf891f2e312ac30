"""Finds the reason for an unreached target: the reach, limits, a collision, or a singularity."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.likely_units import millimeters_in_words
from ulna.ik.options import DEFAULT_BUDGET
from ulna.ik.problem import STEPS, Problem, excess_of, rows_for
from ulna.ik.result import CODES, Status
from ulna.ik.search.restarts import PoseSearch, Restart, run_starts
from ulna.ik.search.starts import limit_starts
from ulna.ik.search.units import jacobian_in_unit
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.layout import COLUMN, FIXED, KIND, LARGEST_DEFECT, REVOLUTE
from ulna.kinematics.jacobian import geometric_jacobian
from ulna.kinematics.turns import turn_towards_middle, turning_columns

Array = NDArray[np.float64]
_STARTS = 64  # starts without limits, before limits are ruled out as the reason
_AT_LIMITS, _AT_ONCE = 512, 64  # starts with joints at their limits, before limits become the reason; targets at once
_SETTLED, _SETTLING_STEPS = 16, 100  # starts that converge to the nearest pose of an unsolved target, and their steps
_SINGULAR = 1e-3  # relative to the largest singular value times the error's size


def close_unreachable(search: PoseSearch) -> None:
    """Mark the targets that are provably out of reach."""
    problem, options, reach = search.problem, search.problem.query.options, search.problem.query.reach
    slack = np.linalg.norm(options.task.slack[:3])
    if reach is None or not np.isfinite(slack):
        return
    order, whole_pose = np.flatnonzero(search.open), options.task.kind == layout.WHOLE_POSE
    excess = reach.excess(_link_targets(problem, order), position_only=not whole_pose)
    turned = options.rotation_tolerance + LARGEST_DEFECT if whole_pose else 0.0
    beyond = excess > slack + options.position_tolerance + turned * np.linalg.norm(reach.end_point)
    for i, value in zip(order[beyond], excess[beyond], strict=True):
        search.reach_excess[int(i)] = float(value - slack)
    search.info["status"][order[beyond]] = CODES[Status.UNREACHABLE]
    search.open[order[beyond]] = False


def reach_in_words(problem: Problem, i: int) -> str:
    """The certificate of unreachable target i, in words."""
    reach, whole_pose = problem.query.reach, problem.query.options.task.kind == layout.WHOLE_POSE
    if reach is None:
        return ""
    distance, min_distance, max_distance = reach.distance(_link_targets(problem, [i]), position_only=not whole_pose)
    what = "the last axis" if whole_pose else "the link"
    hint = millimeters_in_words(float(distance[0]), float(max_distance))
    span = f"{min_distance:.4g} to {max_distance:.4g} m"
    return f"{what} would be {distance[0]:.4g} m{hint} from the first axis, but the arm spans {span}"


def _link_targets(problem: Problem, order: NDArray[np.int64] | list[int]) -> Array:
    """The targets of the link itself, not of the task's frame."""
    targets, R = problem.targets[order].copy(), problem.query.task_axes
    if R is not None:
        targets[:, :3, :3] = targets[:, :3, :3] @ R.T
    return targets


def explain_open(search: PoseSearch, *, out_of_time: bool) -> None:
    """Set the status of every unsolved target, or the solution that the search for a reason finds."""
    problem, options = search.problem, search.problem.query.options
    close_unreachable(search)
    unexplained = _close_collided(search)
    if out_of_time or options.budget < DEFAULT_BUDGET:
        _set(search, unexplained, Status.BUDGET_SPENT)
        return
    if len(unexplained) and problem.is_narrowed:
        narrowed = Status.HELD_JOINTS if options.max_step is None else Status.BEYOND_MAX_STEP
        unexplained = _search_beyond(search, unexplained, problem.query.limits, narrowed)
    if len(unexplained):
        unexplained = _search_beyond(search, unexplained, _without_limits(problem), Status.JOINT_LIMITS)
    for i in unexplained:
        if _is_singular(problem, i, search.q[i], search.info[i]):
            _set(search, np.array([i]), Status.SINGULAR)


def _close_collided(search: PoseSearch) -> NDArray[np.int64]:
    """Close the targets whose solutions all collide. Returns the indices of the others."""
    targets = np.flatnonzero(search.open)
    collided = np.isin(targets, list(search.rejected))
    for i in targets[collided]:
        search.q[i], search.info[i] = search.rejected[int(i)]
    _set(search, targets[collided], Status.IN_COLLISION)
    search.open[targets[collided]] = False
    return targets[~collided]


def _set(search: PoseSearch, targets: NDArray[np.int64], status: Status) -> None:
    search.info["status"][targets] = CODES[status]


def _search_beyond(search: PoseSearch, order: NDArray[np.int64], bounds: Array, status: Status) -> NDArray[np.int64]:
    """Search within wider bounds. If this solves a target, record its smallest excess over the problem's own bounds.

    A result may be within the problem's own bounds, or close to such a solution. So the search first continues within these
    bounds. Returns the indices of the targets that remain unexplained.
    """
    problem = replace(search.problem, bounds=bounds)
    q, info = run_starts(problem, order, Restart(0, _STARTS, 3 * STEPS, from_seed=True))
    own_bounds = rows_for(search.problem.bounds, order)[:, None]
    if status == Status.JOINT_LIMITS:
        q = turn_towards_middle(
            q, own_bounds[:, :, 0], own_bounds[:, :, 1], turning_columns(problem.chain, problem.query.tree.n_dof)
        )
    excess = excess_of(q, own_bounds[:, :, 0], own_bounds[:, :, 1])
    cost = np.where(info["status"] == layout.SOLVED, excess.max(axis=-1), np.inf)
    solved = np.isfinite(cost.min(axis=1))
    if solved.any():
        search.run_from(order[solved], q[solved], STEPS)
        _close_collided(search)
    is_beyond = solved & (cost.min(axis=1) > 0.0)
    if status == Status.JOINT_LIMITS:
        _search_at_limits(search, order[is_beyond & search.open[order]])
    for row in np.flatnonzero(search.open[order] & is_beyond):
        search.limit_excess[int(order[row])] = excess[row, cost[row].argmin()]
        _set(search, order[row : row + 1], status)
        search.open[order[row]] = False
    return order[search.open[order]]


def _search_at_limits(search: PoseSearch, order: NDArray[np.int64]) -> None:
    """Continue the search from configurations with joints at their limits: such solutions are missed most often."""
    for part in (order[begin : begin + _AT_ONCE] for begin in range(0, len(order), _AT_ONCE)):
        search.run_from(part, limit_starts(search.problem, part, _AT_LIMITS), STEPS)
    _close_collided(search)


def _without_limits(problem: Problem) -> Array:
    """Bounds that leave every joint of the chain unlimited.

    Starts of prismatic joints are within one length of their range.
    """
    bounds = problem.query.limits.copy()
    width = np.maximum(bounds[0, 3] - bounds[0, 2], 1e-3 * problem.query.units)
    for row in problem.chain:
        if int(row[KIND]) != FIXED:
            j = int(row[COLUMN])
            bounds[0, :2, j] = -np.inf, np.inf
            is_slide = int(row[KIND]) != REVOLUTE
            bounds[0, 2:, j] = (bounds[0, 2, j] - width[j], bounds[0, 3, j] + width[j]) if is_slide else (-np.pi, np.pi)
    return bounds


def settle_open(search: PoseSearch, *, out_of_time: bool) -> None:
    """Let the best configurations of unsolved targets converge to the nearest reachable pose."""
    problem = search.problem
    unsolved = np.flatnonzero((search.info["status"] != layout.SOLVED) & (search.info["status"] != layout.NOT_A_POSE))
    if out_of_time or problem.query.options.budget < DEFAULT_BUDGET or not len(unsolved):
        return
    round_ = Restart(0, _SETTLED, _SETTLING_STEPS, from_seed=True, calm=True)
    before, with_posture = search.info[unsolved], search.with_posture[unsolved]
    q, info = run_starts(replace(problem, seeds=search.q), unsolved, round_)
    for name in ("start", "iterations"):  # values of the search: the steps that follow do not count
        info[name] = before[name][:, None]
    search.keep(unsolved, q, info, round_)
    search.with_posture[unsolved] = with_posture
    is_unsolved = search.info["status"][unsolved] != layout.SOLVED
    search.info["status"][unsolved[is_unsolved]] = before["status"][is_unsolved]


def _is_singular(problem: Problem, i: int, q: Array, info: Any) -> bool:
    """Whether no joint of an arm of six or more, limits aside, reduces the error: J' e = 0."""
    query = problem.query
    if query.options.task.kind != layout.WHOLE_POSE:
        return False
    J = jacobian_in_unit(problem, geometric_jacobian(query.tree, q, query.link, "base"), query.unit)
    R = problem.targets[i, :3, :3]
    e = np.concatenate([R @ info.residual[:3], R @ info.residual[3:]])
    e[:3] /= query.unit
    moves = (np.abs(J).max(axis=0) > 0).sum() >= 6
    return bool(moves and np.linalg.norm(J.T @ e) < _SINGULAR * np.linalg.norm(e) * np.linalg.norm(J, 2))
