"""Moves the arm between the corners of the demo's trajectory by certified plans that avoid the box."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.demo.scenario import BOX_NAME, RATE_HZ, SEGMENT_S, Demo
from ulna.planning.plan import Plan, PlanStatus
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot

Array = NDArray[np.float64]
NAME = "a plan around the box"  # shown on the page during its compilation
_ACCELERATION = 3.0  # [rad/s^2], for every joint
_VELOCITY = 1.0  # [rad/s], for every joint
_CLEARANCE = 0.01  # [m], clearance of a plan from the box; a dragged box closer than half of it triggers replanning
_MAX_CHECKS = 10_000  # edge checks of one search, about 30 ms; each corner gets two searches before it counts as unreachable
_APART = 0.02  # [s], interval between the configurations whose distance from the box is measured again
_MAX_OF_TRAIL, _TRAIL_STEP = 2000, 0.01  # number of configurations in the trail; change of a joint between them [rad]
_DEEPER = 1e-3  # [m], extra depth allowed on the way back: the distance covers the deepest of many pairs only
_CORNERS = round(SEGMENT_S * RATE_HZ)  # samples of the trajectory from corner to corner


class NextMotion(NamedTuple):
    """The motion to the next corner, and the plan behind it.

    Attributes:
        plan: The plan.
        motion: Its motion, or the motion back along the trail; None if there is neither.
        number: Index of the goal that the motion reaches.
        kept: Length of the trail that remains after a motion back; None for other motions.
    """

    plan: Plan
    motion: Trajectory | None
    number: int = 0
    kept: int | None = None


def plan_motion(robot: Robot, start: Array, goals: Array, world: World, trail: Array) -> NextMotion:
    """Plan a motion to the first reachable configuration; if none is reachable, return the failed plan to the first.

    If a configuration touches the box, any other one with the same pose of the hand serves. The motion keeps the clearance if
    possible, otherwise it only avoids contact. From deep in the box the motion leads back along the trail.
    """
    failed = []
    for number, goal in enumerate(goals):
        plan = _plan(robot, start, goal, world)
        if plan.status == PlanStatus.GOAL_IN_COLLISION:
            plan = _plan(robot, start, robot.forward_kinematics(goal), world)
        if plan:
            return NextMotion(plan, plan.trajectory(velocity=_VELOCITY, acceleration=_ACCELERATION), number)
        failed.append(plan)
    if failed[0].status == PlanStatus.START_IN_COLLISION and (last := _last_free(robot, start, trail, world)) is not None:
        back = np.concatenate([start[None], trail[last:][::-1]])
        return NextMotion(failed[0], robot.trajectory(back, velocity=_VELOCITY, acceleration=_ACCELERATION), kept=last + 1)
    return NextMotion(failed[0], None)


def _last_free(robot: Robot, start: Array, trail: Array, world: World) -> int | None:
    """The index of the last collision-free configuration in the trail; None without one, or if the way back leads deeper.

    The trail has shape (n, n_dof). The middle of each step is checked too.
    """
    free = np.flatnonzero(np.logical_not(robot.in_collision(trail, world)))
    if not len(free):
        return None
    back = np.concatenate([start[None], trail[free[-1] :][::-1]])
    looked_at = np.concatenate([back, (back[1:] + back[:-1]) / 2])
    distances = robot.signed_distance(looked_at, world, self_collision=False)
    return int(free[-1]) if distances.min() >= distances[0] - _DEEPER else None


def _plan(robot: Robot, start: Array, goal: Array, world: World) -> Plan:
    plan = robot.plan(start, goal, world, clearance=_CLEARANCE, escape=True, max_checks=_MAX_CHECKS)
    return plan or robot.plan(start, goal, world, escape=True, max_checks=_MAX_CHECKS)


def is_free(robot: Robot, motion: Trajectory, since: float, world: World) -> bool:
    """Whether the rest of a motion is certified free, and stays clear of the box at configurations 20 ms apart.

    If the arm is near the box or touches it already, the motion only has to lead away: a new plan would start from rest again.
    After a contact, the motion is certified from its first free configuration on.
    """
    n = 1 + int(np.ceil(max(motion.duration - since, 0.0) / _APART))
    times = np.linspace(since, motion.duration, n + 1)
    distances = robot.signed_distance(motion.at(times).q, world, self_collision=False)
    if distances.min() < min(0.5 * _CLEARANCE, distances[0]) or distances[-1] <= 0.0:
        return False
    return motion.is_free(world, since=float(times[np.argmax(distances > 0.0)]))


class BoxAvoidance:
    """Moves the arm around the box to the next corner; plans again if the box is moved into the way.

    Args:
        demo: The demo, with its box.
        ask: Calls functions by ``Compiler.ask``, which returns None while their kernels are compiled.

    Attributes:
        plan: The last plan; None before the first one, and while its kernels are compiled.
        corner: The index of the corner that the arm approaches.
    """

    def __init__(self, demo: Demo, ask: Callable[..., Any]) -> None:
        self._demo, self._ask = demo, ask
        self.plan: Plan | None = None
        self.corner = 0
        self._motion: Trajectory | None = None
        self._time = 0.0
        self._box: Array | None = None  # pose of the box when the motion was last found free
        self._placed: Array | None = None
        self._trail: deque[Array] = deque(maxlen=_MAX_OF_TRAIL)
        self._backs = False

    def remember(self, q: Array) -> None:
        """Record the arm's configuration in the trail, so that the arm can leave the box the way it came."""
        if not self._backs and (not self._trail or np.abs(q - self._trail[-1]).max() > _TRAIL_STEP):
            self._trail.append(q)

    def begin(self) -> None:
        """Plan again from the arm's current configuration."""
        self.plan = self._motion = self._box = self._placed = None
        self._backs = False

    def advance(self, q: Array, seconds: float, corners: Array) -> Array:
        """Advance by a time [s] along the motion; returns q, shape (n_dof,), which is unchanged without a motion.

        q: the current configuration; corners: the configurations to visit, shape (n, n_dof).
        """
        if q is not self._placed:  # something else moved the arm
            self.begin()
        box = self._demo.world.pose(BOX_NAME)
        if self._box is None or not np.array_equal(box, self._box):
            self._update_motion(q, box, corners)
        if self._motion is None:
            return self._keep(q)
        self._time += seconds
        q = self._motion.at(self._time).q
        if self._time >= self._motion.duration:
            self.corner = (self.corner + (not self._backs)) % len(corners)
            self._box, self._motion, self._backs = None, None, False
        return self._keep(q)

    @property
    def sentence(self) -> str:
        """A sentence about the plan."""
        if self.plan is None:
            return "the planner is being compiled"
        if self.plan:
            how = "certified free" if self.plan.certified else "free at samples"
            return f"a path {'out of contact with the box, then' if self.plan.escaped else 'around the box,'} {how}"
        if self._backs:
            return "the arm is in the box, and leaves it the way it came"
        if self.plan.status == PlanStatus.START_IN_COLLISION:
            return "the arm is in the box: move the box away"
        if isinstance(self.plan.reason.data, Report):
            return f"no path around the box: {self.plan.status}"
        return f"no path around the box was found: {self.plan}"

    def _update_motion(self, q: Array, box: Array, corners: Array) -> None:
        """Keep the motion if the rest of it is free; otherwise plan another one."""
        robot, world = self._demo.robot, self._demo.world
        if self._motion is not None and self._ask(NAME, is_free, robot, self._motion, self._time, world):
            self._box = box
            return
        trail = np.array(self._trail).reshape(-1, robot.n_dof)
        found = self._ask(NAME, plan_motion, robot, q, np.roll(corners, -self.corner, axis=0), world, trail)
        if found is None:
            self._motion = None
            return
        self.plan, self._motion, self._backs = found.plan, found.motion, found.kept is not None
        if found.kept is not None:
            self._trail = deque(trail[: found.kept], _MAX_OF_TRAIL)
        self.corner = (self.corner + found.number) % len(corners)
        self._box, self._time = box, 0.0

    def _keep(self, q: Array) -> Array:
        self._placed = q
        return q


def corners_of(samples: Array) -> Array:
    """The configurations at the waypoints of a closed trajectory, without the repeated last one: shape (n, n_dof)."""
    return samples[:-1:_CORNERS]
