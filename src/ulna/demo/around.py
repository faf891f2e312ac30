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
NAME = "a plan around the box"  # which the page shows while it is compiled
_ACCELERATION = 3.0  # [rad/s^2] of every joint
_VELOCITY = 1.0  # [rad/s]
_CLEARANCE = 0.01  # [m] that a plan keeps from the box; while it is dragged nearer than half of this, another one is made
_MAX_CHECKS = 10_000  # of one search, some 30 ms; there are two for each corner before it is said that there is no way
_APART = 0.02  # [s] between two configurations whose distance from the box is measured again
_MAX_OF_TRAIL, _TRAIL_STEP = 2000, 0.01  # configurations of the trail, and the change of a joint between them [rad]
_DEEPER = 1e-3  # [m] that the way back may lead deeper into the box than the arm is: the distance is that of one pair of many
_CORNERS = round(SEGMENT_S * RATE_HZ)  # samples of the trajectory from corner to corner


class Way(NamedTuple):
    """What is known of the way on.

    Attributes:
        plan: The plan.
        motion: Its motion, or the one back; None if there is neither.
        number: Which of the goals it leads to.
        kept: How much of the trail is left behind the end of a motion back; None if the motion is not one.
    """

    plan: Plan
    motion: Trajectory | None
    number: int = 0
    kept: int | None = None


def planned(robot: Robot, start: Array, goals: Array, world: World, trail: Array) -> Way:
    """A motion to the first configuration that can be reached; if none can, the failed plan to the first.

    Where a configuration touches the box, another one with the same pose of the hand will do. The motion keeps the clearance; if
    there is no way that does, it only does not touch. From deep in the box it leads back along the trail.
    """
    failed = []
    for number, goal in enumerate(goals):
        plan = _plan(robot, start, goal, world)
        if plan.status == PlanStatus.GOAL_IN_COLLISION:
            plan = _plan(robot, start, robot.forward_kinematics(goal), world)
        if plan:
            return Way(plan, plan.trajectory(velocity=_VELOCITY, acceleration=_ACCELERATION), number)
        failed.append(plan)
    if failed[0].status == PlanStatus.START_IN_COLLISION and (last := _last_free(robot, start, trail, world)) is not None:
        back = np.concatenate([start[None], trail[last:][::-1]])
        return Way(failed[0], robot.trajectory(back, velocity=_VELOCITY, acceleration=_ACCELERATION), kept=last + 1)
    return Way(failed[0], None)


def _last_free(robot: Robot, start: Array, trail: Array, world: World) -> int | None:
    """The index of the last configuration of the trail that touches nothing; None if all touch, or if going back goes deeper.

    The trail: shape (n, n_dof). The way is looked at in the middle of its steps too.
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
    """Whether the rest of a motion is certified free, and not near the box at configurations 20 ms apart.

    Where the box is near or touches already, the motion is to lead away from it: planned anew it would begin from rest again.
    Where it touches, the motion is certified from the first of these configurations on at which it does not.
    """
    n = 1 + int(np.ceil(max(motion.duration - since, 0.0) / _APART))
    times = np.linspace(since, motion.duration, n + 1)
    distances = robot.signed_distance(motion.at(times).q, world, self_collision=False)
    if distances.min() < min(0.5 * _CLEARANCE, distances[0]) or distances[-1] <= 0.0:
        return False
    return motion.is_free(world, since=float(times[np.argmax(distances > 0.0)]))


class Around:
    """The way around the box: a motion to the next corner, which is planned again when the box is moved into it.

    Args:
        demo: The demo, with its box.
        ask: Calls functions by ``Compiler.ask``: None while their kernels are compiled.

    Attributes:
        plan: The last plan; None before the first one, and while its kernels are compiled.
        corner: The number of the corner that the arm goes to.
    """

    def __init__(self, demo: Demo, ask: Callable[..., Any]) -> None:
        self._demo, self._ask = demo, ask
        self.plan: Plan | None = None
        self.corner = 0
        self._motion: Trajectory | None = None
        self._time = 0.0
        self._box: Array | None = None  # where it was when the motion was last found to be free
        self._placed: Array | None = None
        self._trail: deque[Array] = deque(maxlen=_MAX_OF_TRAIL)
        self._backs = False

    def passed(self, q: Array) -> None:
        """Note where the arm is, by whatever means it came there: it leaves the box the way it came if there is no other."""
        if not self._backs and (not self._trail or np.abs(q - self._trail[-1]).max() > _TRAIL_STEP):
            self._trail.append(q)

    def begin(self) -> None:
        """Plan anew, from wherever the arm is."""
        self.plan = self._motion = self._box = self._placed = None
        self._backs = False

    def advance(self, q: Array, seconds: float, corners: Array) -> Array:
        """Where the arm is after a time [s], shape (n_dof,): on its way, or where it was if there is no way.

        q: where it is; corners: the configurations between which it goes, shape (n, n_dof).
        """
        if q is not self._placed:  # moved by other means
            self.begin()
        box = self._demo.world.pose(BOX_NAME)
        if self._box is None or not np.array_equal(box, self._box):
            self._look_again(q, box, corners)
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
        """What there is to say of the plan."""
        if self.plan is None:
            return "the plan waits for the compiler"
        if self.plan:
            how = "certified free" if self.plan.certified else "free at samples"
            return f"a way {'away from the box, and then' if self.plan.escaped else 'round the box,'} {how}"
        if self._backs:
            return "the arm is in the box, and leaves it the way it came"
        if self.plan.status == PlanStatus.START_IN_COLLISION:
            return "the arm is in the box: move the box away"
        if isinstance(self.plan.reason.data, Report):
            return f"no way round the box: {self.plan.status}"
        return f"no way round the box was found: {self.plan}"

    def _look_again(self, q: Array, box: Array, corners: Array) -> None:
        """Keep the motion if the rest of it is free; else plan another one."""
        robot, world = self._demo.robot, self._demo.world
        if self._motion is not None and self._ask(NAME, is_free, robot, self._motion, self._time, world):
            self._box = box
            return
        trail = np.array(self._trail).reshape(-1, robot.n_dof)
        found = self._ask(NAME, planned, robot, q, np.roll(corners, -self.corner, axis=0), world, trail)
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
    """The configurations at the way points of a trajectory, without the last, which is the first: shape (n, n_dof)."""
    return samples[:-1:_CORNERS]
