"""Plans a motion from a configuration to a goal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World
from ulna.description.semantic import GroupState
from ulna.errors import InputError, UnknownNameError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.problem import as_names
from ulna.ik.reason import Reason
from ulna.ik.task import Task, as_task
from ulna.kinematics.groups import JointGroup, configuration, state_named, tip_of
from ulna.kinematics.positions import as_positions, is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree
from ulna.planning.escape import escape_from
from ulna.planning.goals import Goals, Request, as_goal, find_goals, fixed_for
from ulna.planning.improve import Searched
from ulna.planning.links_goal import as_links_goal, find_links_goals, fixed_for_links, own_columns
from ulna.planning.motion import Motion
from ulna.planning.options import PlanOptions
from ulna.planning.plan import Plan
from ulna.planning.plan_status import PlanStatus
from ulna.planning.search import Search
from ulna.planning.slices import TimeLimit
from ulna.planning.space import columns_of_joints, make_space, slides_without_end
from ulna.planning.spent_budget import budget_spent

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
    targets = _as_targets(goal, tree, start, group, states)
    link = _link_of(targets, link, group)
    _refuse_links_that_stay(targets, link, group, tree)
    names += _outside(group, tree)
    if world is not None and not isinstance(world, World):
        raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")
    if world is not None:
        world = world.snapshot()  # what is planned in does not change under the plan
    request = Request(checker, inverse_kinematics, world, options.clearance, start, names, link, task, options.seed)
    of_links = fixed_for_links(targets, tree) if isinstance(targets, dict) else fixed_for(targets, request)
    fixed = columns_of_joints(tree, names) | of_links if names else of_links
    nothing = np.empty((0, tree.n_dof))
    if not within:
        return Plan(PlanStatus.START_BEYOND_LIMITS, nothing, certified=False, reason=_beyond(checker, start))
    depth, first = 0.0, start
    free = request.is_free(_given(start, targets))
    if not free[0]:
        left = escape_from(request, fixed) if options.escape else None
        if left is None:
            return Plan(PlanStatus.START_IN_COLLISION, nothing, certified=False, reason=request.collision(start))
        first, depth = left
    request = request if first is start else request._replace(start=first)
    if isinstance(targets, dict):
        goals = find_links_goals(request, targets, fixed)
    else:
        goals = find_goals(request, targets, fixed, free[1:])
    if not len(goals.q):
        return Plan(goals.status, nothing, certified=False, reason=goals.reason)
    plan = _search(request, first, goals, fixed, options)
    if first is not start and plan:
        return replace(plan, path=np.concatenate([start[None], plan.path]), escaped=True, escape=depth)
    return plan


def _search(request: Request, start: Array, goals: Goals, fixed: NDArray[np.bool_], options: PlanOptions) -> Plan:
    world = request.world
    far = world.objects().farthest if world is not None and slides_without_end(request.tree) else 0.0
    q, of, certify, limit = goals.q, goals.of, options.certify, TimeLimit(options.time_limit)
    space = make_space(request.tree, np.concatenate([start[None], q]), fixed, far)
    motion = Motion(space, request.checker, world, request.margin)
    if len(q) > 1:
        order = np.argsort(space.lengths(space.shortest_way(q - start)), kind="stable")
        q, of = q[order], of[order]
    searched = Searched(motion, start, q, of, certify, options.seed)
    search = Search(motion.edges(certify=certify), start, q, (searched.seed,))
    found = search.finish(options.max_checks, limit, shorten=options.shorten)
    if found is None:
        name = "max_checks" if search.effort.checks >= options.max_checks else "time_limit"
        reason = budget_spent(request, motion, search, f"{name}={getattr(options, name)}", certify=certify)
        nothing = np.empty((0, request.tree.n_dof))
        return Plan(PlanStatus.BUDGET_SPENT, nothing, certified=False, reason=reason, effort=search.effort)
    certified, goal = certify and found.confirmed, int(of[search.goal])
    return Plan(PlanStatus.SOLVED, found.path, certified, effort=search.effort, goal=goal, _searched=searched)


def _as_targets(
    goal: ArrayLike | Mapping[str, ArrayLike], tree: Tree, start: Array, group: JointGroup | None, states: tuple[GroupState, ...]
) -> Array | dict[str, Array]:
    """A goal as configurations or poses, or as a pose for each of several links."""
    if isinstance(goal, str):
        goal = configuration(state_named(goal, states, group), tree, start)
    return as_links_goal(goal, tree) if isinstance(goal, Mapping) else as_goal(goal, tree, start, group)


def _given(start: Array, targets: Array | dict[str, Array]) -> Array:
    """The configurations that are given, shape (n, n_dof): whether they are free is decided by one call."""
    given = start[None]
    return np.concatenate([given, targets]) if isinstance(targets, np.ndarray) and targets.ndim == 2 else given


def _link_of(targets: Array | dict[str, Array], link: str | None, group: JointGroup | None) -> str | None:
    """The link that a pose is of: that of the group, if none is named.

    Raises:
        InputError: The group has several tips; or a link is named besides those of the goal.
    """
    if isinstance(targets, dict):
        if link is not None:
            raise InputError("link", "the goal names its links already")
        return None
    return link if link is not None or group is None or targets.ndim != 3 else tip_of(group)


def _refuse_links_that_stay(targets: Array | dict[str, Array], link: str | None, group: JointGroup | None, tree: Tree) -> None:
    """Refuse a pose of a link that the group does not move.

    Raises:
        InputError: No joint of the group moves it, and no other link of the goal.
    """
    several = isinstance(targets, dict)
    if group is None or not (several or targets.ndim == 3):
        return
    for name, columns in own_columns(targets if several else {tree.link_or_tip(link): targets}, tree).items():
        if group.columns and not columns[list(group.columns)].any():
            alone = " and no other link of the goal" if len(targets) > 1 and several else ""
            raise InputError("goal" if several else "link", f"no joint of the group {group.name!r} moves link {name!r}{alone}")


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


def _beyond(checker: Checker, start: Array) -> Reason:
    tree, excess = checker.tree, np.maximum(checker.tree.lower - start, start - checker.tree.upper)
    names = [name for name, part in zip(tree.joint_names, tree.joint_slices, strict=True) for _ in range(part.start, part.stop)]
    beyond = {name: float(x) for name, x in zip(names, excess, strict=True) if x > 0}
    return Reason(", ".join(f"{name} by {x:.3g}" for name, x in beyond.items()), beyond)
