"""Plans a motion from a configuration to a goal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World, refuse_no_world
from ulna.description.semantic import GroupState
from ulna.errors import InputError, UnknownNameError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.problem import as_names
from ulna.ik.reason import Reason
from ulna.ik.task import Task, as_task
from ulna.kinematics.groups import JointGroup
from ulna.kinematics.positions import as_positions, is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree
from ulna.planning.escape import escape_from
from ulna.planning.goals import Goals, Request, find_goals
from ulna.planning.motion import Motion
from ulna.planning.options import PlanOptions
from ulna.planning.plan import Plan, PlanStatus, Searched, no_plan
from ulna.planning.search import Search
from ulna.planning.slices import TimeLimit
from ulna.planning.space import columns_of_joints, make_space, slides_without_end
from ulna.planning.spent_budget import budget_spent
from ulna.planning.targets import as_targets, fixed_for, joint_of

Array = NDArray[np.float64]


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
    options: PlanOptions,
) -> Plan:
    """A motion from q_start to a goal; see ``Robot.plan``.

    Raises:
        InputError: An argument that cannot be taken; its name is in the message.
        UnknownNameError: There is no such link, joint or state.
        GeometryError: The robot has no collision shapes, or some that cannot be checked.
    """
    tree, names, _ = checker.tree, as_names(held), as_task(task)
    if link is not None and link not in tree.link_names:
        raise UnknownNameError("link", str(link), tree.link_names)
    start, within = _as_start(q_start, checker)
    targets = as_targets(goal, link, tree, start, group, states)
    names += _outside(group, tree)
    refuse_no_world(world)
    if world is not None:
        world = world.snapshot()  # what is planned in does not change under the plan
    request = Request(checker, inverse_kinematics, world, options.clearance, start, names, task, options.seed)
    fixed = columns_of_joints(tree, names) | fixed_for(targets, tree)
    if not within:
        return no_plan(tree, PlanStatus.START_BEYOND_LIMITS, _beyond(tree, start))
    depth, first = 0.0, start
    given = np.concatenate([start[None], targets]) if isinstance(targets, np.ndarray) else start[None]
    free = request.is_free(given)  # of all by one call
    if not free[0]:
        left = escape_from(request, fixed) if options.escape else None
        if left is None:
            return no_plan(tree, PlanStatus.START_IN_COLLISION, request.collision(start))
        first, depth = left
        request = request._replace(start=first)
    goals = find_goals(request, targets, fixed, free[1:])
    if isinstance(goals, Plan):
        return goals
    plan = _search(request, goals, fixed, options)
    if first is not start and plan:
        return replace(plan, path=np.concatenate([start[None], plan.path]), escaped=True, escape=depth)
    return plan


def _search(request: Request, goals: Goals, fixed: NDArray[np.bool_], options: PlanOptions) -> Plan:
    world, start = request.world, request.start
    far = world.objects().farthest if world is not None and slides_without_end(request.tree) else 0.0
    (q, of), certify = goals, options.certify
    space = make_space(request.tree, np.concatenate([start[None], q]), fixed, far)
    motion = Motion(space, request.checker, world, request.margin)
    if len(q) > 1:
        order = np.argsort(space.lengths(space.shortest_way(q - start)), kind="stable")
        q, of = q[order], of[order]
    search = Search(motion.edges(certify=certify), start, q, (options.seed,))
    found = search.finish(options.max_checks, TimeLimit(options.time_limit), shorten=options.shorten)
    if found is None:
        name = "max_checks" if search.effort.checks >= options.max_checks else "time_limit"
        reason = budget_spent(request, motion, search, f"{name}={getattr(options, name)}", certify=certify)
        return no_plan(request.tree, PlanStatus.BUDGET_SPENT, reason, search.effort)
    certified, goal = certify and found.confirmed, int(of[search.goal])
    searched = Searched(motion, start, q, of, certify, options.seed)
    return Plan(PlanStatus.SOLVED, found.path, certified, effort=search.effort, goal=goal, _searched=searched)


def _outside(group: JointGroup | None, tree: Tree) -> tuple[str, ...]:
    """The joints that are not in the group.

    Raises:
        InputError: There are no others.
    """
    if group is None:
        return ()
    if not group.joint_names:
        raise InputError("group", f"{group.name!r} has no moving joints, so there is nothing to plan")
    return tuple(name for name in tree.joint_names if name not in group.joint_names)


def _as_start(q_start: ArrayLike, checker: Checker) -> tuple[Array, bool]:
    """The start, and whether it is within the limits."""
    start = as_positions(q_start, checker.tree, "q_start")
    if start.ndim != 1:
        raise InputError("q_start", f"shape {start.shape}; one configuration, shape ({checker.tree.n_dof},), is expected")
    if not checker.tree.n_dof:
        raise InputError("q_start", "the robot has no moving joints, so there is nothing to plan")
    within = is_within(start, checker.tree)
    if not within:
        refuse_out_of_range(start, "q_start")
    return start.copy(), within


def _beyond(tree: Tree, start: Array) -> Reason:
    excess = np.maximum(tree.lower - start, start - tree.upper)
    beyond = {joint_of(k, tree): float(excess[k]) for k in np.flatnonzero(excess > 0).tolist()}
    return Reason(", ".join(f"{name} by {x:.3g}" for name, x in beyond.items()), beyond)
