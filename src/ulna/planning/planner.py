"""Plans a motion from a configuration to a goal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World, refuse_no_world
from ulna.description.arrays import as_count, as_number, as_switch
from ulna.description.likely_units import degrees_in_words
from ulna.description.semantic import GroupState
from ulna.errors import InputError, UnknownNameError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.problem import as_names, columns_of_joints
from ulna.ik.reason import Reason
from ulna.ik.task import Task, as_task
from ulna.kinematics.groups import JointGroup
from ulna.kinematics.positions import as_positions, is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree
from ulna.planning.goals import Goals, Request, find_goals
from ulna.planning.keep import Keep
from ulna.planning.kept import are_kept, as_keeps, narrower, table_of, violations
from ulna.planning.kept_goals import find_kept_goals, poses_beside
from ulna.planning.motion import Motion
from ulna.planning.plan import Plan, PlanStatus, Searched, no_plan
from ulna.planning.search import Search
from ulna.planning.slices import MOST_CHECKS, TimeLimit, as_time_limit
from ulna.planning.space import along, make_space, slides_without_end
from ulna.planning.spent_budget import budget_spent
from ulna.planning.targets import as_targets, fixed_for, joint_of

Array = NDArray[np.float64]
_DEEPEST = 0.01  # [m]: a start that is deeper in something is not left
_ESCAPE_STEPS = 30
_ROUNDING = 1e-12  # [rad or m]: of what a motion computes
_BEYOND = 1e-3  # [m]: how far out each step aims
_LARGEST_STEP = 0.05  # rad or m
_ESCAPE_APART = 1e-3  # [rad or m]: of the samples of the way out


class PlanOptions(NamedTuple):
    """The options of ``Robot.plan`` that say how a path is searched for; documented there.

    Their defaults are those of every plan. They are what the caller gave, whatever that is, until they are ``checked``.
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
        """These options as Python's own numbers."""
        if self.progress is not None and not callable(self.progress):
            raise InputError("progress", f"{self.progress!r}; a function of two numbers is expected")
        return PlanOptions(
            as_switch("certify", self.certify),
            as_number("clearance", self.clearance, 0.0, "a distance [m] of at least 0"),
            as_count("seed", self.seed, most=MOST_CHECKS),
            as_count("max_checks", self.max_checks, 1, MOST_CHECKS),
            as_switch("shorten", self.shorten),
            as_switch("escape", self.escape),
            as_time_limit(self.time_limit),
            self.progress,
        )


def plan_motion(
    checker: Checker,
    inverse_kinematics: InverseKinematics,
    q_start: ArrayLike,
    goal: ArrayLike | Mapping[str, ArrayLike],
    world: World | None,
    link: str | None,
    task: Task | str,
    held: Iterable[str],
    group: JointGroup | None,
    states: tuple[GroupState, ...],
    keep: Keep | Iterable[Keep],
    options: PlanOptions,
) -> Plan:
    """A motion from q_start to a goal; see ``Robot.plan``."""
    tree, names, _ = checker.tree, as_names(held), as_task(task)
    if link is not None and link not in tree.link_names:
        raise UnknownNameError("link", str(link), tree.link_names)
    start, within = _as_start(q_start, checker)
    targets = as_targets(goal, link, tree, start, group, states)
    names += _outside(group, tree)
    refuse_no_world(world)
    if world is not None:
        world = world.snapshot()  # what is planned in does not change under the plan
    keeps = as_keeps(keep, tree, start, link, group)
    table = table_of(keeps, tree)
    if keeps and options.escape:
        raise InputError("escape", "the way out of a contact keeps no constraint; it does not go with keep=")
    request = Request(checker, inverse_kinematics, world, options.clearance, start, names, task, options.seed)
    beside = poses_beside(targets, keeps, tree) if keeps else {}
    fixed = columns_of_joints(tree, names) | fixed_for({**targets, **beside} if isinstance(targets, dict) else targets, tree)
    narrow = narrower(table)
    if not within or (narrow is not None and not are_kept(narrow, tree, start[None], start[None])[0]):
        return _no_start(tree, start, keeps, within=within)
    depth, first = 0.0, start
    given = np.concatenate([start[None], targets]) if isinstance(targets, np.ndarray) else start[None]
    free = request.is_free(given)  # of all by one call
    if not free[0]:
        left = _escape_from(request, fixed) if options.escape else None
        if left is None:
            return no_plan(tree, PlanStatus.START_IN_COLLISION, request.collision(start))
        first, depth = left
        request = request._replace(start=first)
    if narrow is None:
        goals = find_goals(request, targets, fixed, free[1:])
    else:
        goals = find_kept_goals(request, targets, beside, fixed, free[1:], keeps, narrow)
    if isinstance(goals, Plan):
        return goals
    plan = _search(request, goals, fixed, table, options)
    if first is not start and plan:
        return replace(plan, path=np.concatenate([start[None], plan.path]), escaped=True, escape=depth)
    return plan


def _no_start(tree: Tree, start: Array, keeps: tuple[Keep, ...], *, within: bool) -> Plan:
    """Why there is no motion from a start that is beyond the limits, or else does not keep the constraints."""
    if not within:
        return no_plan(tree, PlanStatus.START_BEYOND_LIMITS, _beyond(tree, start))
    return no_plan(tree, PlanStatus.START_OUTSIDE, violations(keeps, tree, start))


def _search(request: Request, goals: Goals, fixed: NDArray[np.bool_], keeps: Array | None, options: PlanOptions) -> Plan:
    world, start = request.world, request.start
    far = world.objects().farthest if world is not None and slides_without_end(request.tree) else 0.0
    (q, of), certify = goals, options.certify
    space = make_space(request.tree, np.concatenate([start[None], q]), fixed, far)
    motion = Motion(space, request.checker, world, request.margin, keeps)
    if len(q) > 1:
        order = np.argsort(space.lengths(space.shortest_way(q - start)), kind="stable")
        q, of = q[order], of[order]
    search = Search(motion.edges(certify=certify), start, q, (options.seed,), progress=options.progress)
    found = search.finish(options.max_checks, TimeLimit(options.time_limit), shorten=options.shorten)
    if found is None:
        name = "max_checks" if search.effort.checks >= options.max_checks else "time_limit"
        reason = budget_spent(request, motion, search, f"{name}={getattr(options, name)}", certify=certify)
        return no_plan(request.tree, PlanStatus.BUDGET_SPENT, reason, search.effort)
    certified, goal = certify and found.confirmed, int(of[search.goal])
    searched = Searched(motion, start, q, of, certify, options.seed)
    return Plan(PlanStatus.SOLVED, found.path, certified, effort=search.effort, goal=goal, _searched=searched)


def _outside(group: JointGroup | None, tree: Tree) -> tuple[str, ...]:
    """The joints that are not in the group."""
    if group is None:
        return ()
    if not group.joint_names:
        raise InputError("group", f"{group.name!r} has no moving joints, so there is nothing to plan")
    return tuple(name for name in tree.joint_names if name not in group.joint_names)


def _as_start(q_start: ArrayLike, checker: Checker) -> tuple[Array, bool]:
    """The start, and whether it is within the limits, to which it is brought where it is beyond them by rounding."""
    start = as_positions(q_start, checker.tree, "q_start")
    if start.ndim != 1:
        raise InputError("q_start", f"shape {start.shape}; one configuration, shape ({checker.tree.n_dof},), is expected")
    if not checker.tree.n_dof:
        raise InputError("q_start", "the robot has no moving joints, so there is nothing to plan")
    if is_within(start, checker.tree):
        return start.copy(), True
    refuse_out_of_range(start, "q_start")
    inside = np.clip(start, checker.tree.least, checker.tree.most)
    return (inside, True) if (np.abs(inside - start) <= _ROUNDING).all() else (start.copy(), False)


def _beyond(tree: Tree, start: Array) -> Reason:
    excess = np.maximum(tree.lower - start, start - tree.upper)
    beyond = {joint_of(k, tree): float(excess[k]) for k in np.flatnonzero(excess > 0).tolist()}
    return Reason(", ".join(f"{name} by {x:.3g}" for name, x in beyond.items()) + degrees_in_words(start), beyond)


def _escape_from(request: Request, fixed: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """A free configuration near the start, and how deep the start is [m]; None if it is too deep, or none is found.

    Steps along the gradient of the signed distance, of the entries of q that are not ``fixed``, each out of the deepest pair. On
    the straight way there, at samples, nothing touches but what touches at the start.
    """
    depth, tree = max(_missing(request, request.start)), request.tree
    if not depth <= _DEEPEST:
        return None
    q = request.start.copy()
    for _ in range(_ESCAPE_STEPS):
        gradient = np.where(fixed, 0.0, _way_out(request, q))
        square = float(gradient @ gradient)
        if square == 0.0:
            return None
        step = gradient * ((max(_missing(request, q)) + _BEYOND) / square)
        q = np.clip(q + step * min(1.0, _LARGEST_STEP / np.abs(step).max()), tree.lower, tree.upper)
        if request.is_free(q[None])[0]:
            return (q, max(depth, 0.0)) if _touches_nothing_else(request, q) else None
    return None


def _missing(request: Request, q: Array) -> tuple[float, float]:
    """How much the robot is too near to itself, and to the world, of which it is to keep the margin [m]."""
    checker, world = request.checker, request.world
    itself = -float(checker.signed_distance(q, None, self_collision=True))
    if world is None or not world.names:
        return itself, -np.inf
    return itself, request.margin - float(checker.signed_distance(q, world, self_collision=False))


def _way_out(request: Request, q: Array) -> Array:
    """The gradient in q of the distance of the pair that is too near by most."""
    itself, world = _missing(request, q)
    if world > itself:
        return request.checker.distance_gradient(q, request.world, self_collision=False)
    return request.checker.distance_gradient(q, None, self_collision=True)


def _touches_nothing_else(request: Request, q: Array) -> bool:
    """Whether all that touches on the way from the start to q touches at the start too, looked at every ``_ESCAPE_APART``."""
    touching = {(pair.name_a, pair.name_b) for pair in request.touching(request.start)}
    way = along(request.start, q, _ESCAPE_APART)
    near = (request.touching(there) for there in way[~request.is_free(way)])
    return all((pair.name_a, pair.name_b) in touching for pairs in near for pair in pairs)
