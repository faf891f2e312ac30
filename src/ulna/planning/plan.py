"""Defines the result of planning: a path from a configuration to a goal, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_count, as_floats, as_number
from ulna.errors import InputError, count_of
from ulna.ik.reason import NO_REASON, Reason
from ulna.ik.time_limit import TimeLimit, as_time_limit
from ulna.kinematics.tree import Tree, entry_names
from ulna.notebook.tables import OneLine, table
from ulna.planning.boundary_velocities import as_ends, connect_ends, refuse_path_beyond
from ulna.planning.constraint_table import worst_violation
from ulna.planning.entries.search_records import AORRTC, RRT_CONNECT
from ulna.planning.faster_path import find_faster_path
from ulna.planning.fixed_joints_first import chain_joints
from ulna.planning.hand import HandLimits, as_hands
from ulna.planning.motion import Motion
from ulna.planning.motion_limits import GivenLimits, as_motion_limits
from ulna.planning.motors import as_caps
from ulna.planning.path_limits import refuse_ends
from ulna.planning.positions import PositionLimits
from ulna.planning.search import Effort, Search
from ulna.planning.slices import MAX_CHECKS
from ulna.planning.space import same_entries
from ulna.planning.targets import joint_name, limit_excess
from ulna.planning.trajectory import Trajectory, trajectory_at_rest

Array = NDArray[np.float64]
_SAMPLES = 256  # configurations at which the clearance is measured
_MIN_GAIN = 1e-4  # minimum relative improvement of the length
_MAX_NAMED = 3  # joints named in a message
_FIRST_CHECKS = 256  # edges of a search for a shorter path; doubled after each failure


class PlanStatus(StrEnum):
    """The outcome of planning."""

    SOLVED = "solved"
    START_IN_COLLISION = "start in collision"
    START_BEYOND_LIMITS = "start beyond limits"
    GOAL_IN_COLLISION = "goal in collision"
    GOAL_UNREACHABLE = "goal unreachable"
    START_OUTSIDE = "start outside"
    GOAL_OUTSIDE = "goal outside"
    BUDGET_SPENT = "budget spent"


class Searched(NamedTuple):
    """The problem that a search solved, with which ``Plan.improve`` continues.

    Attributes:
        motion: The robot, the world and the space of the joints that may move.
        start: The start of the certified part of the path, shape (n_dof,).
        goals: The goal configurations, shape (n, n_dof).
        goal_index: The index of the given goal that each configuration solves, shape (n,).
        certify: Whether edges are certified.
        seed: The seed of the plan.
        n_searches: The number of searches so far.
    """

    motion: Motion
    start: Array
    goals: Array
    goal_index: NDArray[np.int64]
    certify: bool
    seed: int
    n_searches: int = 1


@dataclass(frozen=True, eq=False, repr=False)
class Plan(OneLine):
    """The result of ``Robot.plan``: a path of straight edges in joint space. ``bool(plan)`` is True if a path was found.

    ======================= =============================================================================================
    ``solved``              ``path`` leads from the start to a goal.
    ``start in collision``  The start touches something; ``reason.data`` is the ``Report``.
    ``start beyond limits`` The start violates the joint limits; the limits of held joints count too.
    ``goal in collision``   Every goal touches something; ``reason.data`` is the ``Report`` of the first.
    ``goal unreachable``    No configuration was found for the pose; ``reason.data`` is the ``IKResult``.
    ``start outside``       The start violates a constraint; ``reason.data`` is a tuple of ``Violation``.
    ``goal outside``        Every free goal violates a constraint; ``reason.data`` has the violations of the first.
    ``budget spent``        ``max_checks`` edges were checked, or ``time_limit`` is over. ``reason.data`` is a ``SpentBudget``:
                            the limit, and what blocked the last edges. A path may exist nevertheless.
    ======================= =============================================================================================

    Attributes:
        status: The outcome of planning.
        path: The configurations [rad or m], shape (n, n_dof), from the start to a goal. The goal may differ by whole turns of
            joints without limits. n = 0 without a path.
        certified: Whether every edge of the path is certified to be free at all its configurations, as by
            ``Robot.edge_in_collision``; if ``escaped``, all edges but the first. Otherwise edges were checked at samples.
            Constraints are certified either way.
        reason: Why there is no path; empty if there is one.
        effort: The effort of the search.
        escaped: Whether the start touched something, or was beyond the joint limits, and the first edge leads out of it. An edge
            out of a contact is not certified; at samples it touches only what the start touches. An edge back within the joint
            limits touches nothing, but may violate the clearance and the constraints.
        escape: The penetration depth of an escaped start [m]; else 0.
        goal: The index of the given goal that is reached; -1 without a path.
    """

    status: PlanStatus
    path: Array
    certified: bool
    reason: Reason = NO_REASON
    effort: Effort = field(default_factory=Effort)
    escaped: bool = False
    escape: float = 0.0
    goal: int = -1
    _searched: Searched | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        self.path.setflags(write=False)

    def __bool__(self) -> bool:
        return self.status == PlanStatus.SOLVED

    @property
    def success(self) -> bool:
        """Whether a path was found."""
        return bool(self)

    @property
    def checks(self) -> int:
        """The number of edges checked by search and shortening."""
        return self.effort.checks

    @property
    def length(self) -> float:
        """The Euclidean length of the path [rad], with slides weighted (docs/planning_search.md); 0 without a path."""
        return float(self._lengths[-1]) if len(self.path) else 0.0

    @cached_property
    def clearance(self) -> float:
        """The least distance from an object of the world [m], at 256 evenly spaced configurations; infinite without a world.

        It is computed at first use. A certified path is free between these configurations too.
        """
        if self._motion is None:
            return np.inf
        return self._motion.clearance(self.at(np.linspace(0.0, 1.0, _SAMPLES)))

    @cached_property
    def worst_violation(self) -> float:
        """The largest share of its tolerance that a constraint uses at any time: a certified bound, below 1.

        The bound is at most 0.001 too large; 0 without constraints. For an angle it is a share of the sine of the half angle.
        """
        return 0.0 if self._motion is None else worst_violation(self._motion.keeps, self._motion.checker.tree, self.path)

    @cached_property
    def moved(self) -> tuple[str, ...]:
        """The joints that move although both ends have the same position: no path was found with all of them held."""
        return () if self._motion is None else _joint_names(self._returning_entries, self._motion.checker.tree)

    @cached_property
    def moved_beside(self) -> tuple[str, ...]:
        """The joints of ``moved`` outside the moving arm, such as a lift, fingers or another arm."""
        if self._motion is None:
            return ()
        tree, returning = self._motion.checker.tree, self._returning_entries
        changed = (self.path != self.path[:1]).any(axis=0) & ~returning
        return _joint_names(returning & ~chain_joints(tree, changed), tree)

    @property
    def _returning_entries(self) -> NDArray[np.bool_]:
        """Mask of the entries of q that change along the path but are the same at both ends, shape (n_dof,)."""
        if self._motion is None or not self:
            return np.zeros(self.path.shape[1], dtype=bool)
        return same_entries(self._motion.checker.tree, *self.path[[0, -1]]) & (self.path != self.path[0]).any(axis=0)

    @cached_property
    def _lengths(self) -> Array:
        """The length of the path up to each configuration, shape (n,)."""
        differences = np.diff(self.path, axis=0)
        steps = np.linalg.norm(differences, axis=1) if self._motion is None else self._motion.space.lengths(differences)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def at(self, s: ArrayLike) -> Array:
        """The configuration at a share of the path's length.

        Args:
            s: Shares in [0, 1], shape (...).

        Returns:
            Joint positions [rad or m], shape (..., n_dof).

        Raises:
            InputError: There is no path, or s is not in [0, 1].
        """
        s = as_floats("s", s)
        if not len(self.path):
            raise InputError("s", f"there is no path: {self.status}")
        if not ((s >= 0.0) & (s <= 1.0)).all():
            raise InputError("s", "shares of the path's length, from 0 to 1, are expected")
        if len(self.path) == 1:
            return np.broadcast_to(self.path[0], (*s.shape, self.path.shape[1])).copy()
        along = s * self._lengths[-1]
        i = np.clip(np.searchsorted(self._lengths, along, side="right") - 1, 0, len(self.path) - 2)
        step = self._lengths[i + 1] - self._lengths[i]
        share = np.clip((along - self._lengths[i]) / np.where(step > 0.0, step, 1.0), 0.0, 1.0)
        q = self.path[i] + share[..., None] * (self.path[i + 1] - self.path[i])
        return np.where(share[..., None] >= 1.0, self.path[i + 1], q)

    def trajectory(
        self,
        *,
        acceleration: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        blend: float = 0.1,
        jerk: ArrayLike | None = None,
        limits: GivenLimits | None = None,
        hand: HandLimits | Iterable[HandLimits] | None = None,
        torque: ArrayLike | None = None,
        start_velocity: ArrayLike | None = None,
        end_velocity: ArrayLike | None = None,
        time_limit: float | None = None,
    ) -> Trajectory:
        """Compute the time-optimal trajectory along the path within limits, by TOPP-RA (Pham and Pham 2018).

        Args:
            acceleration: Maximum acceleration of each joint [rad/s^2 or m/s^2], a number or n_dof numbers; required unless
                ``limits`` or the robot has it.
            velocity: Maximum velocity [rad/s or m/s], a number or n_dof numbers; the robot's limits unless given.
            blend: The largest part of its two edges that a rounded corner replaces, in the plan's metric [rad]; at most half of
                each edge. The rounding is a parabola and is certified like an edge; if it is not free, it is made smaller. If no
                rounding is free, and at every corner for ``blend=0``, the motion stops at the corner.
            jerk: Maximum jerk [rad/s^3 or m/s^3], a number or n_dof numbers; unless given from ``limits`` or the robot, if they
                have it. The trajectory is then smoothed by a moving average over a short time. It leaves the path at corners
                slightly, which is certified too. Controllers that refuse jumps of the acceleration, such as a Franka's, need it.
            limits: The name of an arm, as "franka", a file ``joint_limits.yaml`` in MoveIt's format, or its mapping: limits that
                are not given as numbers (docs/trajectories.md lists the arms and the sources). The file's position limits apply
                too.
            hand: Maximum speed and acceleration of the hand, or of several links, at all times.
            torque: Maximum torque of each joint [Nm or N], a number or n_dof numbers; True for the effort limits of the
                description. Gravity and attached objects count. Torques are checked at samples of the motion at most 2 ms apart,
                with a margin of 0.5 % of each limit.
            start_velocity: The velocity at the start [rad/s or m/s], shape (n_dof,); the acceleration there is 0. At rest unless
                given. If it is not along the first edge, the motion continues straight as far as needed. Then it goes to the
                second point of the path; all of it is certified.
            end_velocity: The velocity at the end, likewise.
            time_limit: The maximum computation time [s]; no limit unless given. Tight constraints with a jerk limit take
                seconds. It is checked between steps.

        Returns:
            A ``Trajectory``: times, q, qd, qdd, and ``at(t)``.

        Raises:
            InputError: There is no path, or it exceeds the positions of ``limits``; no acceleration is given, or a limit is not
                above 0. Or a velocity at an end exceeds its limit, or a joint could not stop within its range. Or no connection
                to the path is within the limits and certified to be free; or ``time_limit`` is over.
            UnknownNameError: There is no such set of limits.
            FileError: The file of limits cannot be read.
            DescriptionError: The file has no valid limits.
        """
        if not self or self._motion is None:
            raise InputError("plan", f"there is no path: {self.status}")
        blend, limit = as_number("blend", blend, 0.0, "a length of at least 0"), TimeLimit(as_time_limit(time_limit))
        limit.begin(perf_counter())
        tree = self._motion.checker.tree
        names = tuple(entry_names(tree))
        kept, positions = as_motion_limits(tree, velocity, acceleration, jerk, limits)
        if self.escaped:
            positions = _widen_to_start(positions, self.path[0], tree)
        refuse_path_beyond("limits", self.path, positions, names)
        ends = as_ends(start_velocity, end_velocity, self.path, kept, positions, names)
        caps = as_caps(hand, torque, tree, self._motion.dynamics)
        refuse_ends(caps, self.path, ends)
        if len(self.path) == 1 and not np.any(ends):
            still = trajectory_at_rest(
                self.path[0], names, certified=self.certified, motion=self._motion, limits=kept, positions=positions
            )
            return replace(still, _caps=caps)
        certificate = self._motion.certificate._replace(positions=positions, caps=caps, limit=limit)
        path = self.path if kept.jerk is None else self._motion.subdivide(self.path, positions)
        timed = connect_ends(path, ends, blend, kept, certificate, self._motion.space.lengths, names)
        certified = self.certified and not self.escaped
        return Trajectory(certified, names, timed, self._motion, kept, ends, positions, caps)

    def improve(self, max_checks: int = 10_000, *, time_limit: float | None = None) -> Plan:
        """Search for a shorter path with AORRTC, and return a plan with the shortest one found.

        AORRTC: Wilson, Thomason, Kingston and Gammell (RA-L 2025). Each search has new trees and new samples. Its path is
        shortened, and the length bounds the next search. With constraints, each search is an RRT-Connect along the constraints,
        limited to the region of shorter paths.

        The length converges to the minimum as ``max_checks`` grows. The same calls give the same bits.

        Args:
            max_checks: The maximum number of further edges that the searches check; shortening a path may exceed it.
            time_limit: The maximum time of the searches [s]; no limit unless given. If it ends them, the result depends on the
                machine.

        Returns:
            A ``Plan`` with the checks added; with the same path if no shorter one was found.

        Raises:
            InputError: There is no path, or an argument is invalid.

        Example:
            >>> import ulna
            >>> panda, world = ulna.load("panda"), ulna.World()
            >>> world.add("post", ulna.Box((0.1, 0.1, 1.2)), ulna.pose((0.5, 0.0, 0.6)))
            >>> left, right = panda.home + 0.0, panda.home + 0.0
            >>> left[0], right[0] = 0.8, -0.8
            >>> plan = panda.plan(left, right, world)
            >>> plan.improve(1000).length <= plan.length
            True
        """
        max_checks, limit = as_count("max_checks", max_checks, 1, MAX_CHECKS), TimeLimit(as_time_limit(time_limit))
        if self._searched is None or not self:
            raise InputError("plan", f"there is no path: {self.status}")
        motion, start, goals, goal_index, certify, seed, n_searches = self._searched
        outside = self.path[:1] if self.escaped else self.path[:0]  # the escape edge stays
        path, goal, certified, effort = self.path[len(outside) :], self.goal, self.certified, self.effort
        space, edges = motion.space, motion.edges(certify=certify)
        straight = space.lengths(space.shortest_way(goals - start)).min()
        most, budget = effort.checks + max_checks, _FIRST_CHECKS
        algorithm = AORRTC if motion.keeps is None else RRT_CONNECT  # the edges of AORRTC cannot follow constraints
        if motion.keeps is not None:
            budget = max(budget, effort.checks)  # a path along constraints has many edges
        while effort.checks < most:
            length = space.lengths(np.diff(path, axis=0)).sum()
            bound = length * (1.0 - _MIN_GAIN)
            if bound <= straight or limit.is_over():
                break
            below = edges.with_bound(bound, start, goals)
            search = Search(below, start, goals, (seed, n_searches), algorithm, skip_direct=True)
            found, n_searches = search.finish(min(budget, most - effort.checks), limit, shorten=True), n_searches + 1
            effort = effort.plus(search.effort)
            if found is None:
                budget *= 2  # start small: small trees are cheap, and other samples may succeed
            elif found.confirmed and space.lengths(np.diff(found.path, axis=0)).sum() < length:
                path, goal, certified = found.path, int(goal_index[search.goal]), certify
        searched = self._searched._replace(n_searches=n_searches)
        path = np.concatenate([outside, path])
        return replace(self, path=path, certified=certified, effort=effort, goal=goal, _searched=searched)

    def quicker(
        self,
        tries: int = 300,
        *,
        acceleration: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        blend: float = 0.1,
        jerk: ArrayLike | None = None,
        limits: GivenLimits | None = None,
        hand: HandLimits | Iterable[HandLimits] | None = None,
        torque: ArrayLike | None = None,
    ) -> Plan:
        """Search for a path with a shorter motion time within these limits, by random changes of the path's points.

        Shortening and ``improve`` minimize the length. The time of a motion depends on which joints move, and on how sharply the
        path turns. The edges of each candidate are certified (or checked at samples, as in this plan). Its whole trajectory is
        computed, with certified corners. The same calls give the same bits.

        Args:
            tries: The number of candidates; each takes about as long as ``trajectory``.
            acceleration: Maximum acceleration; this and the following arguments are those of ``trajectory``.
            velocity: Maximum velocity.
            blend: The largest part of its edges that a rounded corner replaces.
            jerk: Maximum jerk.
            limits: The name of an arm, or a file ``joint_limits.yaml``.
            hand: Maximum speed and acceleration of the hand, or of several links.
            torque: Maximum torque of each joint.

        Returns:
            A ``Plan``; call its ``trajectory`` with the same limits. It has the same path if no candidate was faster.

        Raises:
            InputError: See ``trajectory``; or ``tries`` is not a whole number of at least 1.
            UnknownNameError, FileError, DescriptionError: See ``trajectory``.
        """
        tries = as_count("tries", tries, 1, MAX_CHECKS)
        if self._searched is None or not self:
            raise InputError("plan", f"there is no path: {self.status}")
        motion, certify = self._searched.motion, self._searched.certify
        edges, first, tree = motion.edges(certify=certify), 1 + int(self.escaped), motion.checker.tree
        hands = [each.limits for each in as_hands(hand, tree)]

        def duration_of(path: Array) -> float:
            plan = replace(self, path=path)
            timed = plan.trajectory(
                acceleration=acceleration, velocity=velocity, blend=blend, jerk=jerk, limits=limits, hand=hands, torque=torque
            )
            return timed.duration

        duration_of(self.path)  # raises errors for invalid arguments, also for a path of one point
        if len(self.path) <= first:
            return self
        bounds = np.minimum(tree.lower, self.path.min(axis=0)), np.maximum(tree.upper, self.path.max(axis=0))
        path = find_faster_path(
            self.path, motion.space.radians, first, bounds, tries, self._searched.seed, duration_of,
            lambda path: edges.checked(path) is not None,
        )  # fmt: skip
        return replace(self, path=path)

    @property
    def _motion(self) -> Motion | None:
        return None if self._searched is None else self._searched.motion

    @property
    def _moved_text(self) -> str:
        """The end of a message that names moved joints outside the moving arm."""
        names, more = self.moved_beside, len(self.moved_beside) - _MAX_NAMED
        some = ", ".join(names[:_MAX_NAMED]) + (f" and {more} more" if more > 0 else "")
        return f"; no path was found without moving {some} too" if names else ""

    def __getstate__(self) -> dict:
        return {name: value for name, value in self.__dict__.items() if name != "_lengths"}

    def __setstate__(self, state: dict) -> None:
        self.__dict__.update(state)
        self.path.setflags(write=False)

    def _repr_html_(self) -> str:
        if not self or self._motion is None:
            return table(repr(self)[1:-1])
        tree, ends = self._motion.checker.tree, self.path[[0, -1]]
        moves = np.abs(np.diff(self.path, axis=0)).sum(axis=0)
        rows = zip(entry_names(tree), *ends.tolist(), moves.tolist(), strict=True)
        return table(repr(self)[1:-1], ("joint", "start", "end", "moves by"), rows, ["in rad; m for slides"])

    @property
    def _start_text(self) -> str:
        """The text that says why the first edge is an escape."""
        beyond = {} if self._motion is None else limit_excess(self.path[0], self._motion.checker.tree)
        words = ", ".join(f"{name} by {x:.3g}" for name, x in beyond.items())
        return f"the start is beyond the limits: {words}" if beyond else f"the start touches by {self.escape * 1e3:.2g} mm"

    def __str__(self) -> str:
        if self:
            how = "certified free" if self.certified else "free at samples"
            n = len(self.path)
            left = f"; {self._start_text}, and the first edge leads out of it" if self.escaped else ""
            points = f"{count_of(n, 'configuration')}, length {self.length:.3g}"
            return f"solved: {points}, {how}, after {count_of(self.checks, 'checked edge')}{left}{self._moved_text}"
        return f"{self.status}: {self.reason}"


def _widen_to_start(positions: PositionLimits, start: Array, tree: Tree) -> PositionLimits:
    """Position limits widened to include a start beyond the robot's limits, from which the motion returns."""
    lower = np.where(start < tree.lower, np.minimum(positions.lower, start), positions.lower)
    return PositionLimits(lower, np.where(start > tree.upper, np.maximum(positions.upper, start), positions.upper))


def _joint_names(columns: NDArray[np.bool_], tree: Tree) -> tuple[str, ...]:
    """The names of the joints to which entries of q belong."""
    return tuple(dict.fromkeys(joint_name(k, tree) for k in np.flatnonzero(columns).tolist()))


def no_plan(tree: Tree, status: PlanStatus, reason: Reason, effort: Effort | None = None) -> Plan:
    """A plan without a path, with the reason."""
    return Plan(status, np.empty((0, tree.n_dof)), certified=False, reason=reason, effort=effort or Effort())
