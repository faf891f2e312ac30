"""Holds a motion from a configuration to a goal, or why there is none."""

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
from ulna.planning.boundary_velocities import as_ends, refuse_path_beyond, with_ends
from ulna.planning.constraint_table import worst_violation
from ulna.planning.faster_path import quicker_path
from ulna.planning.fixed_joints_first import arm_of
from ulna.planning.hand import HandLimits, as_hands
from ulna.planning.motion import Motion
from ulna.planning.motion_limits import GivenLimits, as_motion_limits
from ulna.planning.motors import as_caps
from ulna.planning.path_limits import refuse_ends
from ulna.planning.positions import PositionLimits
from ulna.planning.search import Effort, Search
from ulna.planning.search_records import AORRTC, RRT_CONNECT
from ulna.planning.slices import MAX_CHECKS
from ulna.planning.space import same_entries
from ulna.planning.targets import beyond_limits, joint_of
from ulna.planning.trajectory import Trajectory, resting

Array = NDArray[np.float64]
_SAMPLES = 256  # at which the clearance is measured
_WORTH = 1e-4  # of the length: a path is to be shorter by more
_MAX_NAMED = 3  # joints in a sentence
_FIRST_CHECKS = 256  # of a search for a shorter path, until one has failed


class PlanStatus(StrEnum):
    """How a search for a plan ended."""

    SOLVED = "solved"
    START_IN_COLLISION = "start in collision"
    START_BEYOND_LIMITS = "start beyond limits"
    GOAL_IN_COLLISION = "goal in collision"
    GOAL_UNREACHABLE = "goal unreachable"
    START_OUTSIDE = "start outside"
    GOAL_OUTSIDE = "goal outside"
    BUDGET_SPENT = "budget spent"


class Searched(NamedTuple):
    """What was searched for, so that the search can go on.

    Attributes:
        motion: What may be moved, the robot and the world.
        start: Where the certified part of the path begins, shape (n_dof,).
        goals: Shape (n, n_dof).
        of: Which of the given goals each of them is, shape (n,).
        certify: Whether edges are certified.
        seed: That of the plan.
        n_searches: How many searches there were.
    """

    motion: Motion
    start: Array
    goals: Array
    of: NDArray[np.int64]
    certify: bool
    seed: int
    n_searches: int = 1


@dataclass(frozen=True, eq=False, repr=False)
class Plan(OneLine):
    """A motion from a start to a goal: straight lines between configurations. ``if plan:`` asks whether there is one.

    ======================= =============================================================================================
    ``solved``              ``path`` leads from the start to a goal.
    ``start in collision``  The start touches something; ``reason.data`` is the ``Report``.
    ``start beyond limits`` The start is not within the joint limits; those of joints that are held count too.
    ``goal in collision``   Every goal touches something; ``reason.data`` is the ``Report`` of the first.
    ``goal unreachable``    No configuration was found for the pose; ``reason.data`` is the ``IKResult``.
    ``start outside``       The start does not keep a constraint; ``reason.data`` is a tuple of ``Violation``: which, by how much.
    ``goal outside``        No goal that is free keeps the constraints; ``reason.data`` is that of the first.
    ``budget spent``        ``max_checks`` edges were checked, or ``time_limit`` is over; ``reason.data`` is a ``SpentBudget``:
                            which, and what stopped edges last. That says nothing about whether there is a way.
    ======================= =============================================================================================

    Attributes:
        status: How the search ended.
        path: The configurations [rad or m], shape (n, n_dof), the first the start and the last a goal, but for whole turns of
            joints without limits; n = 0 if there is none.
        certified: Whether every edge of the path is certified, as by ``Robot.edge_in_collision``: free at all of its
            configurations; all but the first if ``escaped``. Else they were checked at samples. The constraints are certainly
            kept either way.
        reason: Why there is no path; no reason if there is one.
        effort: What it took.
        escaped: Whether the start touched something, or was beyond the joint limits, and was left for all that: the first edge
            leads out of it. Out of a contact it is not certified; at samples it touches only what the start touches. Back within
            limits it touches nothing, but keeps neither the clearance nor the constraints.
        escape: How deep the start touched something then [m]; else 0.
        goal: Which goal is reached, of those given; -1 if none.
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
        """Whether there is a path."""
        return bool(self)

    @property
    def checks(self) -> int:
        """How many edges were checked, by search and shortening."""
        return self.effort.checks

    @property
    def length(self) -> float:
        """The length of the path [rad]: Euclidean, with slides weighed as docs/planning_search.md says; 0 without a path."""
        return float(self._lengths[-1]) if len(self.path) else 0.0

    @cached_property
    def clearance(self) -> float:
        """The least distance from an object of the world [m] at 256 evenly spaced configurations; infinite without a world.

        It is measured when first asked for. What is certified lies between these configurations too.
        """
        if self._motion is None:
            return np.inf
        return self._motion.clearance(self.at(np.linspace(0.0, 1.0, _SAMPLES)))

    @cached_property
    def worst_violation(self) -> float:
        """The greatest share of its tolerance that a constraint of the plan uses, at all times: a certified bound, below 1.

        It is by no more than 0.001 too large; 0 without constraints. That of an angle is a share of the sine of half of it.
        """
        return 0.0 if self._motion is None else worst_violation(self._motion.keeps, self._motion.checker.tree, self.path)

    @cached_property
    def moved(self) -> tuple[str, ...]:
        """The joints that move although their position is the same at both ends: with all of them held no path was found."""
        return () if self._motion is None else _names_of(self._returning, self._motion.checker.tree)

    @cached_property
    def moved_beside(self) -> tuple[str, ...]:
        """The joints of ``moved`` beside the arm that moves, such as a lift, fingers or another arm."""
        if self._motion is None:
            return ()
        tree, returning = self._motion.checker.tree, self._returning
        changed = (self.path != self.path[:1]).any(axis=0) & ~returning
        return _names_of(returning & ~arm_of(tree, changed), tree)

    @property
    def _returning(self) -> NDArray[np.bool_]:
        """Which entries of q change along the path, and are the same at both ends, shape (n_dof,)."""
        if self._motion is None or not self:
            return np.zeros(self.path.shape[1], dtype=bool)
        return same_entries(self._motion.checker.tree, *self.path[[0, -1]]) & (self.path != self.path[0]).any(axis=0)

    @cached_property
    def _lengths(self) -> Array:
        """The length of the path up to each of its configurations."""
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
        """The path with times: the fastest motion along it within limits, by TOPP-RA (Pham and Pham 2018).

        Args:
            acceleration: The greatest acceleration of each joint [rad/s^2 or m/s^2], a number or n_dof numbers; needed unless
                ``limits`` or the robot states one.
            velocity: The greatest velocity [rad/s or m/s], a number or n_dof numbers; the robot's limits unless given.
            blend: How much of each of its two edges, in the plan's metric [rad], a rounded corner takes at most; half of an edge
                is the most. A rounding is a parabola, and is certified as the edges are; one that is not free is made smaller.
                Where none is free, and everywhere for 0, the motion stops at the corner.
            jerk: The greatest jerk [rad/s^3 or m/s^3], a number or n_dof numbers; unless given that of ``limits`` or of the
                robot, if one states it. With it the motion is the mean of one without it over a short time, which leaves the path
                at its corners by a distance that is certified too. An arm whose controller refuses jumps of the acceleration, as
                a Franka's does, needs it.
            limits: The name of an arm, as "franka", or a file ``joint_limits.yaml`` as MoveIt has it, or its mapping: the limits
                not given as numbers (docs/trajectories.md names the arms and the sources). The file's positions are kept.
            hand: The greatest speed and acceleration of the hand, or of several links, at all times.
            torque: The greatest torque of each joint [Nm or N], a number or n_dof numbers; for True the limits of effort of the
                description. Gravity and what is attached count. Torques are judged at samples of the motion at most 2 ms apart,
                with 0.5 % of each limit to spare.
            start_velocity: The velocity at the start [rad/s or m/s], shape (n_dof,), where the acceleration is 0; at rest unless
                given. Where it is not along the first edge, the motion goes straight on as far as it needs, and from there to the
                second point of the path; all of that is certified.
            end_velocity: The same at the end.
            time_limit: The longest time to compute it [s]; no limit unless given. A tight constraint and a limit of jerk take
                seconds. What was begun is ended before it is looked at.

        Returns:
            A ``Trajectory``: times, q, qd, qdd, and ``at(t)``.

        Raises:
            InputError: There is no path, or one beyond the positions of ``limits``; no acceleration is given, or a limit is not
                above 0; or a velocity at an end is beyond its limit, a joint could not stop before the end of its range, or no
                way into the path is within the limits and certified free; or ``time_limit`` is over.
            UnknownNameError: There is no such set of limits.
            FileError: The file of limits cannot be read.
            DescriptionError: The file is none of limits.
        """
        if not self or self._motion is None:
            raise InputError("plan", f"there is no path: {self.status}")
        blend, limit = as_number("blend", blend, 0.0, "a length of at least 0"), TimeLimit(as_time_limit(time_limit))
        limit.begin(perf_counter())
        tree = self._motion.checker.tree
        names = tuple(entry_names(tree))
        kept, positions = as_motion_limits(tree, velocity, acceleration, jerk, limits)
        if self.escaped:
            positions = _with_start(positions, self.path[0], tree)
        refuse_path_beyond("limits", self.path, positions, names)
        ends = as_ends(start_velocity, end_velocity, self.path, kept, positions, names)
        caps = as_caps(hand, torque, tree, self._motion.dynamics)
        refuse_ends(caps, self.path, ends)
        if len(self.path) == 1 and not np.any(ends):
            still = resting(self.path[0], names, certified=self.certified, motion=self._motion, limits=kept, positions=positions)
            return replace(still, _caps=caps)
        is_free = self._motion.certificate._replace(positions=positions, caps=caps, limit=limit)
        path = self.path if kept.jerk is None else self._motion.finer(self.path, positions)
        timed = with_ends(path, ends, blend, kept, is_free, self._motion.space.lengths, names)
        certified = self.certified and not self.escaped
        return Trajectory(certified, names, timed, self._motion, kept, ends, positions, caps)

    def improve(self, max_checks: int = 10_000, *, time_limit: float | None = None) -> Plan:
        """A plan with a shorter path, if one is found: searches for paths shorter than the best, by AORRTC.

        AORRTC: Wilson, Thomason, Kingston and Gammell (RA-L 2025). Each search has new trees and other samples; what it finds is
        shortened, and its length bounds the next search. With constraints each is a search as of the plan, along them, where a
        shorter path may pass.

        The length goes towards the least one as ``max_checks`` grows. The same calls give the same bits.

        Args:
            max_checks: How many edges are checked at most, besides those of the plan. Shortening a path that was found may go on.
            time_limit: The longest time of the searches [s]; no limit unless given. Where it ends them, the result depends on the
                machine.

        Returns:
            A ``Plan`` with its checks added; with the same path if none was found that is shorter.

        Raises:
            InputError: There is no path, or an argument cannot be taken.

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
        motion, start, goals, of, certify, seed, n_searches = self._searched
        outside = self.path[:1] if self.escaped else self.path[:0]  # the edge that leads out of a contact stays
        path, goal, certified, effort = self.path[len(outside) :], self.goal, self.certified, self.effort
        space, edges = motion.space, motion.edges(certify=certify)
        straight = space.lengths(space.shortest_way(goals - start)).min()
        most, budget = effort.checks + max_checks, _FIRST_CHECKS
        algorithm = AORRTC if motion.keeps is None else RRT_CONNECT  # the edges of AORRTC lead along no constraint
        if motion.keeps is not None:
            budget = max(budget, effort.checks)  # along constraints there are many edges to a path
        while effort.checks < most:
            length = space.lengths(np.diff(path, axis=0)).sum()
            bound = length * (1.0 - _WORTH)
            if bound <= straight or limit.is_over():
                break
            below = edges.below(bound, start, goals)
            search = Search(below, start, goals, (seed, n_searches), algorithm, by_samples=True)
            found, n_searches = search.finish(min(budget, most - effort.checks), limit, shorten=True), n_searches + 1
            effort = effort.plus(search.effort)
            if found is None:
                budget *= 2  # not all at once: a small tree costs less, and other samples may do better
            elif found.confirmed and space.lengths(np.diff(found.path, axis=0)).sum() < length:
                path, goal, certified = found.path, int(of[search.goal]), certify
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
        """A plan whose motion within these limits takes less time, if one is found: points of the path are moved at random.

        Shortening and ``improve`` look at the length. A motion's time depends on which joints move, and how sharply it turns.
        Each path that is tried has certified edges (or samples, as this plan's), and its whole motion is made, with certified
        corners. The same calls give the same bits.

        Args:
            tries: How many paths are tried; each takes about as long as ``trajectory``.
            acceleration: As of ``trajectory``, and so are the others.
            velocity: The greatest velocity.
            blend: How much of its edges a rounded corner takes at most.
            jerk: The greatest jerk.
            limits: The name of an arm, or a file ``joint_limits.yaml``.
            hand: The greatest speed and acceleration of the hand, or of several links.
            torque: The greatest torque of each joint.

        Returns:
            A ``Plan``, to call ``trajectory`` of with the same limits; this one's path if none was quicker.

        Raises:
            InputError: As of ``trajectory``; or ``tries`` is not a whole number of at least 1.
            UnknownNameError, FileError, DescriptionError: As of ``trajectory``.
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

        duration_of(self.path)  # refuses what cannot be taken, of a path of one point too
        if len(self.path) <= first:
            return self
        bounds = np.minimum(tree.lower, self.path.min(axis=0)), np.maximum(tree.upper, self.path.max(axis=0))
        path = quicker_path(
            self.path, motion.space.radians, first, bounds, tries, self._searched.seed, duration_of,
            lambda path: edges.checked(path) is not None,
        )  # fmt: skip
        return replace(self, path=path)

    @property
    def _motion(self) -> Motion | None:
        return None if self._searched is None else self._searched.motion

    @property
    def _of_moved(self) -> str:
        """The sentence about joints beside the moving arm that move too."""
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
    def _of_start(self) -> str:
        """The reason for the first edge of an escape, in words."""
        beyond = {} if self._motion is None else beyond_limits(self.path[0], self._motion.checker.tree)
        words = ", ".join(f"{name} by {x:.3g}" for name, x in beyond.items())
        return f"the start is beyond the limits: {words}" if beyond else f"the start touches by {self.escape * 1e3:.2g} mm"

    def __str__(self) -> str:
        if self:
            how = "certified free" if self.certified else "free at samples"
            n = len(self.path)
            left = f"; {self._of_start}, and the first edge leads out of it" if self.escaped else ""
            points = f"{count_of(n, 'configuration')}, length {self.length:.3g}"
            return f"solved: {points}, {how}, after {count_of(self.checks, 'checked edge')}{left}{self._of_moved}"
        return f"{self.status}: {self.reason}"


def _with_start(positions: PositionLimits, start: Array, tree: Tree) -> PositionLimits:
    """Limits of position, as wide as a start that is beyond the robot's: the motion begins there, and goes back."""
    lower = np.where(start < tree.lower, np.minimum(positions.lower, start), positions.lower)
    return PositionLimits(lower, np.where(start > tree.upper, np.maximum(positions.upper, start), positions.upper))


def _names_of(columns: NDArray[np.bool_], tree: Tree) -> tuple[str, ...]:
    """The joints to which entries of q belong."""
    return tuple(dict.fromkeys(joint_of(k, tree) for k in np.flatnonzero(columns).tolist()))


def no_plan(tree: Tree, status: PlanStatus, reason: Reason, effort: Effort | None = None) -> Plan:
    """A plan without a path, and why there is none."""
    return Plan(status, np.empty((0, tree.n_dof)), certified=False, reason=reason, effort=effort or Effort())
