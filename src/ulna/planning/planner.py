"""Plans a path from a configuration to a goal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from operator import is_
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import RESOLUTION, Checker
from ulna.collision.world import World, refuse_no_world
from ulna.description.arrays import as_count, as_number, as_switch
from ulna.description.likely_units import degrees_in_words
from ulna.description.semantic import GroupState
from ulna.dynamics.dynamics import Dynamics
from ulna.errors import InputError, UnknownNameError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.reason import Reason
from ulna.ik.task import Task, as_task
from ulna.ik.time_limit import TimeLimit, as_time_limit
from ulna.kinematics.groups import JointGroup
from ulna.kinematics.positions import as_names, as_positions, columns_of_joints, is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree
from ulna.planning.constrained_goals import find_goals, relative_goal_poses
from ulna.planning.constraint_table import as_keeps, make_constraint_table, satisfy_constraints, shrink_tolerances, violations
from ulna.planning.failure_report import report_spent_budget
from ulna.planning.fixed_joints_first import Trial, chain_joints, distal_joints, make_trials, prepend_near_trials
from ulna.planning.goals import Goals, Request
from ulna.planning.keep import Keep
from ulna.planning.motion import Motion
from ulna.planning.plan import Plan, PlanStatus, Searched, no_plan
from ulna.planning.search import Effort, FoundPath, Search
from ulna.planning.slices import MAX_CHECKS
from ulna.planning.space import has_endless_slide, make_space, same_entries, sample_line
from ulna.planning.targets import Targets, as_targets, fixed_entries, limit_excess

Array = NDArray[np.float64]
_MAX_PENETRATION = 0.01  # [m]: maximum penetration of a start for an escape
_ESCAPE_STEPS = 30
_ROUNDING = 1e-12  # [rad or m]: a smaller excess over a limit is rounding
_ESCAPE_CLEARANCE = 1e-3  # [m]: clearance that each step of an escape aims at
_MAX_STEP = 0.05  # [rad or m]
_ESCAPE_SPACING = 1e-3  # [rad or m]: spacing of the samples on the escape edge


class PlanOptions(NamedTuple):
    """The options of the search of ``Robot.plan``, which documents them, with their defaults.

    The values are unvalidated until ``checked()``.
    """

    certify: bool = True
    clearance: float = 0.0
    seed: int = 0
    max_checks: int = 100_000
    shorten: bool = True
    escape: bool = False
    time_limit: float | None = 10.0
    progress: Callable[[int, int], object] | None = None

    def checked(self) -> PlanOptions:
        """A validated copy, with Python numbers.

        Raises:
            InputError: A value is invalid.
        """
        if all(map(is_, self, _DEFAULTS)):
            return self
        if self.progress is not None and not callable(self.progress):
            raise InputError("progress", f"{self.progress!r}; a function of two numbers is expected")
        return PlanOptions(
            as_switch("certify", self.certify),
            as_number("clearance", self.clearance, 0.0, "a distance [m] of at least 0"),
            as_count("seed", self.seed, most=MAX_CHECKS),
            as_count("max_checks", self.max_checks, 1, MAX_CHECKS),
            as_switch("shorten", self.shorten),
            as_switch("escape", self.escape),
            as_time_limit(self.time_limit),
            self.progress,
        )


_DEFAULTS = PlanOptions()


@dataclass(frozen=True)
class PlanRequest:
    """The arguments of ``Robot.plan``, which documents them. ``states`` are the named states of the SRDF."""

    q_start: ArrayLike
    goal: ArrayLike | Mapping[str, ArrayLike]
    world: World | None
    link: str | None
    task: Task | str
    held: Iterable[str]
    group: JointGroup | None
    states: tuple[GroupState, ...]
    keep: Keep | Iterable[Keep]
    options: PlanOptions
    dynamics: Dynamics


def plan_motion(checker: Checker, inverse_kinematics: InverseKinematics, asked: PlanRequest) -> Plan:
    """Plan a path from a start to a goal; see ``Robot.plan``."""
    options, tree = asked.options, checker.tree
    request, targets, within = _check_request(checker, inverse_kinematics, asked)
    start, fixed, table = request.start, request.fixed, request.search_constraints
    given = start
    if not within and options.escape:
        found = _move_within_limits(request)
        if isinstance(found, Plan):
            return found
        start, within = found, True
        request = request._replace(start=start)
    if not within or (table is not None and not satisfy_constraints(table, tree, start[None], start[None])[0]):
        return _failed_start(request, within=within)
    depth, first = 0.0, start
    every = np.concatenate([start[None], targets]) if isinstance(targets, np.ndarray) else start[None]
    free = request.is_free(every)  # one call for all configurations
    if not free[0]:
        left = _find_escape(request, targets, fixed) if options.escape else None
        if left is None:
            return no_plan(tree, PlanStatus.START_IN_COLLISION, request.collision(start))
        first, depth = left
        request = request._replace(start=first)
    goals = find_goals(request, targets, free[1:])
    if isinstance(goals, Plan):
        return goals
    plan = _search(request, goals, options)
    if first is not given and plan:
        return replace(plan, path=np.concatenate([given[None], plan.path]), escaped=True, escape=depth)
    return plan


def _check_request(checker: Checker, inverse_kinematics: InverseKinematics, asked: PlanRequest) -> tuple[Request, Targets, bool]:
    """Check the arguments: the request, the goal, and whether the start is within the limits.

    Raises:
        InputError, UnknownNameError: See ``Robot.plan``.
    """
    tree, link, group, options = checker.tree, asked.link, asked.group, asked.options
    names, _ = as_names(asked.held), as_task(asked.task)
    if link is not None and link not in tree.link_names:
        raise UnknownNameError("link", str(link), tree.link_names)
    start, within = _check_start(asked.q_start, checker)
    targets = as_targets(asked.goal, link, tree, start, group, asked.states)
    names += _joints_outside(group, tree)
    refuse_no_world(asked.world)
    world = None if asked.world is None else asked.world.snapshot()  # later changes of the world do not affect the plan
    keeps = as_keeps(asked.keep, tree, start, link, group)
    if keeps and options.escape:
        raise InputError("escape", "an escape does not satisfy constraints; leave out escape=True or keep=")
    relative_poses = relative_goal_poses(targets, keeps, tree) if keeps else {}
    all_targets = {**targets, **relative_poses} if isinstance(targets, dict) else targets
    fixed = columns_of_joints(tree, names) | fixed_entries(all_targets, tree)
    constraints = make_constraint_table(keeps, tree)
    request = Request(
        tree,
        checker,
        inverse_kinematics,
        world,
        options.clearance,
        start,
        names,
        asked.task,
        options.seed,
        fixed,
        keeps,
        constraints,
        shrink_tolerances(constraints),
        relative_poses,
        asked.dynamics,
    )
    return request, targets, within


def _failed_start(request: Request, *, within: bool) -> Plan:
    """The failed plan for a start beyond the limits, or for a start that violates the constraints."""
    tree, start = request.tree, request.start
    if not within:
        return no_plan(tree, PlanStatus.START_BEYOND_LIMITS, _limits_reason(request))
    return no_plan(tree, PlanStatus.START_OUTSIDE, violations(request.keeps, tree, start))


def _search(request: Request, goals: Goals, options: PlanOptions) -> Plan:
    """Search with joints held that have the same position at both ends, in each trial fewer; return the first path."""
    tree, start, fixed, (q, goal_index) = request.tree, request.start, request.fixed, goals
    motion = _motion(request, q, fixed)
    lengths = motion.space.lengths(motion.space.shortest_way(q - start))
    order = np.argsort(lengths, kind="stable")
    q, goal_index = q[order], goal_index[order]
    same = same_entries(tree, start, q)
    q = np.where(same, start, q)
    last, effort = Trial(fixed, np.arange(len(q)), options.max_checks), Effort()
    *trials, last = prepend_near_trials((*make_trials(tree, same, fixed), last), lengths[order])
    for trial in (*trials, last):
        if trials:
            motion = _motion(request, q[trial.goals], trial.fixed)
        most, limit = _trial_budget(trial, len(trials), effort, options, is_last=trial is last)
        edges, progress = motion.edges(certify=options.certify), _add_earlier_progress(effort, options)
        search = Search(edges, start, q[trial.goals], (options.seed,), progress=progress)
        found = search.finish(most, limit, shorten=options.shorten)
        effort = effort.plus(search.effort)
        if found is not None:
            searched = Searched(motion, start, search.goals, goal_index[trial.goals], options.certify, options.seed)
            reached = search.goal
            goal = int(searched.goal_index[reached])
            searched, found, n = _hold_unneeded_joints(searched, found, same[trial.goals][reached], shorten=options.shorten)
            effort, certified = replace(effort, checks=effort.checks + n), options.certify and found.confirmed
            return Plan(PlanStatus.SOLVED, found.path, certified, effort=effort, goal=goal, _searched=searched)
        if trial is last:
            name = "max_checks" if effort.checks >= options.max_checks else "time_limit"
            limited = f"{name}={getattr(options, name)}"
            reason = report_spent_budget(request, motion, search.refused, effort, limited, certify=options.certify)
            return no_plan(tree, PlanStatus.BUDGET_SPENT, reason, effort)
    raise AssertionError("the last search holds no joint that may move")


def _motion(request: Request, q: Array, fixed: NDArray[np.bool_]) -> Motion:
    """The motion (robot, world, space of the free joints) for a search to goals, shape (n, n_dof)."""
    tree, world = request.tree, request.world
    far = world.objects().farthest if world is not None and has_endless_slide(tree) else 0.0
    space = make_space(tree, np.concatenate([request.start[None], q]), fixed, far)
    return Motion(space, request.checker, world, request.margin, request.constraints, request.dynamics)


def _trial_budget(trial: Trial, n_trials: int, effort: Effort, options: PlanOptions, *, is_last: bool) -> tuple[int, TimeLimit]:
    """The budget of a trial in edges and in time; the last trial gets at least half of both."""
    seconds = options.time_limit
    if is_last:
        most = max(1, options.max_checks - effort.checks)
        return most, TimeLimit(seconds if seconds is None or not n_trials else seconds / 2)
    most = min(trial.checks, max(1, options.max_checks // (2 * n_trials)))
    return most, TimeLimit(None if seconds is None else seconds / (2 * n_trials))


def _add_earlier_progress(effort: Effort, options: PlanOptions) -> Callable[[int, int], object] | None:
    """The caller's progress function, with the edges of earlier searches added."""
    progress = options.progress
    return None if progress is None else lambda checks, _: progress(effort.checks + checks, options.max_checks)


def _hold_unneeded_joints(
    searched: Searched, found: FoundPath, same: NDArray[np.bool_], *, shorten: bool
) -> tuple[Searched, FoundPath, int]:
    """Hold joints outside the moving arm, all or one by one, if the path stays free without their motion.

    same: mask of the entries of q with the same value at the start and at the reached goal, shape (n_dof,).

    Returns:
        The search and the path, with more joints held, and the number of checked edges.
    """
    motion, n_checks = searched.motion, 0
    changed = (found.path != found.path[0]).any(axis=0)
    columns = np.flatnonzero(same & changed & ~distal_joints(motion.checker.tree, motion.space.moving & ~same))
    for some in (columns, *columns[:, None]) if len(columns) > 1 else columns[:, None]:
        if not motion.space.moving[some].any():
            break
        path, held = found.path.copy(), motion._replace(space=motion.space.hold(some, searched.start))
        path[:, some] = searched.start[some]
        edges = held.edges(certify=searched.certify)
        free, checks = edges.check_and_count(path)
        n_checks += checks
        if free is None:
            continue
        if shorten:
            shorter, checks = edges.check_and_count(free, shorten=True)
            n_checks, free = n_checks + checks, free if shorter is None else shorter
        kept = (searched.goals[:, some] == searched.start[some]).all(axis=1)
        motion, found = held, FoundPath(free, confirmed=True)
        searched = searched._replace(motion=motion, goals=searched.goals[kept], goal_index=searched.goal_index[kept])
    return searched, found, n_checks


def _joints_outside(group: JointGroup | None, tree: Tree) -> tuple[str, ...]:
    """The names of the joints outside the group."""
    if group is None:
        return ()
    if not group.joint_names:
        raise InputError("group", f"{group.name!r} has no moving joints, so there is nothing to plan")
    return tuple(name for name in tree.joint_names if name not in group.joint_names)


def _check_start(q_start: ArrayLike, checker: Checker) -> tuple[Array, bool]:
    """The checked start, and whether it is within the limits; an excess within rounding is clipped."""
    start = as_positions(q_start, checker.tree, "q_start")
    if start.ndim != 1:
        raise InputError("q_start", f"shape {start.shape}; one configuration, shape ({checker.tree.n_dof},), is expected")
    if not checker.tree.n_dof:
        raise InputError("q_start", "the robot has no moving joints, so there is nothing to plan")
    if is_within(start, checker.tree):
        return start.copy(), True
    refuse_out_of_range(start, "q_start")
    inside = np.clip(start, checker.tree.lower_finite, checker.tree.upper_finite)
    return (inside, True) if (np.abs(inside - start) <= _ROUNDING).all() else (start.copy(), False)


def _limits_reason(request: Request, more: str = "") -> Reason:
    """The reason that names the joints beyond their limits at the start, with a remedy."""
    tree, start = request.tree, request.start
    beyond = limit_excess(start, tree)
    words = ", ".join(f"{name} by {x:.3g}" for name, x in beyond.items())
    hint = degrees_in_words(start)
    if not hint and not more and not (request.fixed & (start != np.clip(start, tree.lower, tree.upper))).any():
        hint = "; escape=True first moves back within them"
    return Reason(words + more + hint, beyond)


def _move_within_limits(request: Request) -> Array | Plan:
    """The nearest configuration within the limits, or a failed plan if the edge to it is not free."""
    tree, start = request.tree, request.start
    inside = np.clip(start, tree.lower_finite, tree.upper_finite)
    if (request.fixed & (inside != start)).any():
        return no_plan(tree, PlanStatus.START_BEYOND_LIMITS, _limits_reason(request, ", which is held"))
    ways = request.checker.edge_in_collision(start, inside, request.world, self_collision=True, resolution=RESOLUTION)
    if ways.in_collision or not request.is_free(inside[None])[0]:
        return no_plan(
            tree, PlanStatus.START_BEYOND_LIMITS, _limits_reason(request, "; the straight edge back within them is not free")
        )
    return inside


def _find_escape(request: Request, targets: Targets, fixed: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """Find an escape with ``_escape``: first with joints held that need not move, then with all free joints.

    Joints need not move if they are outside the moving arm and have the same position at the start and the goals.
    """
    if isinstance(targets, np.ndarray):
        same = same_entries(request.tree, request.start, targets).all(axis=0)
        held = fixed | (same & ~chain_joints(request.tree, ~(same | fixed)))
        found = _escape(request, held)
        if found is not None:
            return found
    return _escape(request, fixed)


def _escape(request: Request, fixed: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """Find a free configuration near the start, and the start's penetration depth [m].

    It returns None if the start is too deep, or no configuration is found. Each step follows the gradient of the deepest pair's
    signed distance in the entries of q that are not ``fixed``. On the straight edge to the result, at samples, only pairs touch
    that touch at the start.
    """
    depth, tree = max(_clearance_violations(request, request.start)), request.tree
    if not depth <= _MAX_PENETRATION:
        return None
    q = request.start.copy()
    for _ in range(_ESCAPE_STEPS):
        gradient = np.where(fixed, 0.0, _escape_gradient(request, q))
        square = float(gradient @ gradient)
        if square == 0.0:
            return None
        step = gradient * ((max(_clearance_violations(request, q)) + _ESCAPE_CLEARANCE) / square)
        q = np.clip(q + step * min(1.0, _MAX_STEP / np.abs(step).max()), tree.lower, tree.upper)
        if request.is_free(q[None])[0]:
            return (q, max(depth, 0.0)) if _touches_nothing_else(request, q) else None
    return None


def _clearance_violations(request: Request, q: Array) -> tuple[float, float]:
    """The violations of clearance [m]: between the robot's links, and of the margin from the world."""
    checker, world = request.checker, request.world
    itself = -float(checker.signed_distance(q, None, self_collision=True))
    if world is None or not world.names:
        return itself, -np.inf
    return itself, request.margin - float(checker.signed_distance(q, world, self_collision=False))


def _escape_gradient(request: Request, q: Array) -> Array:
    """The gradient with respect to q of the distance of the pair with the largest violation."""
    itself, world = _clearance_violations(request, q)
    if world > itself:
        return request.checker.distance_gradient(q, request.world, self_collision=False)
    return request.checker.distance_gradient(q, None, self_collision=True)


def _touches_nothing_else(request: Request, q: Array) -> bool:
    """Whether only pairs that touch at the start touch on the edge to q, at samples ``_ESCAPE_SPACING`` apart."""
    touching = {(pair.name_a, pair.name_b) for pair in request.touching(request.start)}
    way = sample_line(request.start, q, _ESCAPE_SPACING)
    near = (request.touching(there) for there in way[~request.is_free(way)])
    return all((pair.name_a, pair.name_b) in touching for pairs in near for pair in pairs)
