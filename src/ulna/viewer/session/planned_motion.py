"""Plans the motion of a view's arm to a goal, samples its curves, and moves the arm along it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.description.pose import as_one_pose
from ulna.errors import count_of
from ulna.ik.result import IKResult
from ulna.planning.plan import Plan, PlanStatus
from ulna.planning.timing import QUANTITIES
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot
from ulna.viewer.session.session import Session
from ulna.viewer.session.waypoints import Leg, MotionSettings, Waypoint, gripper_of, join_legs, plan_through

NAME = "planning a motion"
JERK = 30.0  # [rad/s^3 or m/s^3] the limit of every joint, if the jerk is limited
_POINTS = 200  # points of the drawn line, for each leg
_SAMPLES = 400  # samples of a curve
Array = NDArray[np.float64]


Goals = tuple[Array | None, tuple[Waypoint, ...]]


@dataclass(frozen=True, eq=False)
class Curve:
    """One quantity of a motion over time.

    Attributes:
        t: Times [s], shape (n,).
        values: The quantity of each entry of q, in radians or meters and seconds, shape (n, n_dof).
        low, high: The limits of the quantity, shape (n_dof,) each; infinite where there are none.
    """

    t: Array
    values: Array
    low: Array
    high: Array

    @property
    def shares(self) -> Array:
        """The values scaled to -1 at the lower and 1 at the upper limit, shape (n, n_dof); NaN without limits."""
        with np.errstate(invalid="ignore", divide="ignore"):
            middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
            return np.where(np.isfinite(half) & (half > 0.0), (self.values - middle) / half, np.nan)


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """A plan as it is shown.

    Attributes:
        plan: The plan.
        motion: Its timed trajectory; None if there is no path.
        line: The positions of the hand along the motion [m], shape (n, 3).
        end: The last configuration of the path, shape (n_dof,). Without a path it is the goal. For the pose of a goal it is the
            nearest configuration that inverse kinematics finds without a world.
        curves: The plotted curves of the motion by quantity; empty without a motion.
        kept_line: The ends of the line on which the hand is kept [m], shape (2, 3); None if there is none.
        legs: The legs of the motion.
        n_reached: The number of waypoints reached; the goal counts as the last one.
    """

    plan: Plan
    motion: Trajectory | None
    line: Array
    end: Array
    curves: dict[str, Curve] = field(default_factory=dict)
    kept_line: Array | None = None
    legs: tuple[Leg, ...] = ()
    n_reached: int = 0


def plan_motion(robot: Robot, start: Array, stops: tuple[Waypoint, ...], world: World, settings: MotionSettings) -> PlannedMotion:
    """Plan a motion from a configuration through waypoints; the last one is the goal."""
    legs, n_reached = plan_through(robot, start, stops, world, settings)
    link, last, line, motion = settings.link, legs[-1], legs[-1].line, join_legs(legs)
    if motion is None:
        end, goal = last.goal, last.goal
        if goal.ndim == 2:
            of = last.plan.reason.data  # of a goal out of reach: the nearest solution, whose distance the sentence gives
            held = settings.held
            near = of if isinstance(of, IKResult) else robot.inverse_kinematics(goal, last.start, link=link, held=held)
            end = near.q
        return PlannedMotion(last.plan, None, np.empty((0, 3)), end, kept_line=line, legs=tuple(legs), n_reached=n_reached)
    q = motion.at(np.linspace(0.0, motion.duration, _POINTS * len(legs))).q
    way = robot.forward_kinematics(q, link=link)[:, :3, 3]
    return PlannedMotion(last.plan, motion, way, motion.q[-1], curves_of(motion), line, tuple(legs), n_reached)


def curves_of(motion: Trajectory) -> dict[str, Curve]:
    """The curves of a motion by quantity, without the jerk if it is unlimited, since then the acceleration jumps."""
    t = np.linspace(0.0, motion.duration, _SAMPLES)
    values: dict[str, Array] = dict(zip(QUANTITIES, motion.at(t), strict=True))
    return {name: Curve(t, values[name], *ends) for name, ends in motion.limits.items()}


class Planning:
    """A goal, the planned motion to it, and the position along it. Hold the session's lock around its methods.

    It plans again when the goal or an obstacle was moved. If the arm was moved by other means, the plan starts from there.

    Attributes:
        on: Whether it plans.
        jerk: The jerk limit of the motion [rad/s^3 or m/s^3]; None for no limit.
        upright: Whether the direction of the hand that points up at the start is kept upright.
        on_line: Whether the hand is kept on the line to the goal.
        held: The joints that keep their positions, besides those of the session.
        waypoints: The waypoints before the present goal.
        shown: The plan; None without a goal, and while its kernels are compiled.
        waiting: Whether its kernels are being compiled.
        share: The share of the motion's duration that has passed, from 0 to 1.
        playing: Whether the arm moves along the motion.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self.on = self.playing = self.waiting = False
        self.share = 0.0
        self.jerk: float | None = None
        self.upright = self.on_line = False
        self.held: tuple[str, ...] = ()
        self.waypoints: tuple[Waypoint, ...] = ()
        self.shown: PlannedMotion | None = None
        self._goal: Array | None = None
        self._start = session.q
        self._own_configurations = (session.q,)  # where it has put the arm: two configurations while it moves the arm, else one
        self._request: tuple | None = None
        self._link = session.link

    @property
    def target(self) -> None:
        """None: nothing pulls the goal. See ``Session.target``."""

    @property
    def hand_pose(self) -> Array:
        """The goal of the hand, T_base_hand, shape (4, 4); its present pose while there is no goal."""
        session = self._session
        if self._goal is None:
            return session.hand_pose
        return self._goal.copy() if self._goal.ndim == 2 else session.robot.forward_kinematics(self._goal, link=session.link)

    @property
    def frames(self) -> dict[str, Array]:
        """See ``Session.frames``."""
        return self._session.frames

    def send(self, T_base_hand: ArrayLike) -> None:
        """Choose a pose of the hand as the goal, shape (4, 4).

        Raises:
            InputError: It is not a pose.
        """
        self._goal = as_one_pose(T_base_hand, "T_base_hand")

    def send_configuration(self, q: ArrayLike) -> None:
        """Choose a configuration as the goal, shape (n_dof,)."""
        self._goal = as_floats("q", q).copy()

    def add_waypoint(self, approach: float = 0.0, retract: float = 0.0, opening: float | None = None) -> None:
        """Add the goal as a waypoint, or the present configuration if there is no goal."""
        goal = self._session.q if self._goal is None else self._goal
        self.goals = None, (*self.waypoints, Waypoint(goal, approach, retract, opening))

    def remove_waypoint(self) -> None:
        """Remove the last waypoint, which becomes the goal unless there is one."""
        if self.waypoints:
            *others, last = self.waypoints
            self.goals = (last.goal if self._goal is None else self._goal), (*others,)

    @property
    def has_gripper(self) -> bool:
        """Whether the hand has fingers that open."""
        return len(gripper_of(self._session.robot, self._session.link)) > 0

    def describe_waypoint(self, stop: Waypoint) -> str:
        """A line of text for a waypoint: its position, approach, retract and gripper opening."""
        T = stop.goal if stop.goal.ndim == 2 else self._session.robot.forward_kinematics(stop.goal, link=self._session.link)
        words = ", ".join(f"{value + 0.0:.3f}" for value in T[:3, 3].round(3)) + " m"
        for name, way in (("approach", stop.approach), ("retract", stop.retract)):
            words += f", {name} {1e3 * way:g} mm" if way else ""
        return words if stop.opening is None else f"{words}, gripper {100 * stop.opening:g} % open"

    @property
    def goals(self) -> Goals:
        """The goal, or None, and the waypoints before it."""
        return self._goal, self.waypoints

    @goals.setter
    def goals(self, goals: Goals) -> None:
        self._goal, self.waypoints = goals
        if self._goal is None and not self.waypoints:
            self.shown, self._request = None, None

    @property
    def settings(self) -> MotionSettings:
        """The options with which it plans."""
        return MotionSettings(self._session.link, (*self._session.held, *self.held), self.jerk, self.upright, self.on_line)

    def turn(self, *, on: bool) -> None:
        """Begin planning from the present configuration and without a goal, or end it."""
        self._begin(None, (), on=on)

    def play(self) -> None:
        """Move the arm along the motion, from the start if it is at the end; or pause it."""
        if self.playing or self.shown is None or self.shown.motion is None:
            self.playing = False
            return
        self.share, self.playing = (0.0 if self.share >= 1.0 else self.share), True

    def scrub(self, share: float) -> None:
        """Put the arm at a share of the motion's duration, from 0 to 1."""
        self.share, self.playing = min(max(float(share), 0.0), 1.0), False

    def frame(self, seconds: float) -> bool:
        """Plan if something has changed, and advance the arm by a time [s]. Returns whether the plan has changed."""
        if not self.on:
            return False
        q = self._session.q
        if self._session.link != self._link or not any(np.array_equal(q, own) for own in self._own_configurations):
            self.start_here()
        another = self._plan()
        motion = None if self.shown is None else self.shown.motion
        if motion is None:
            self.playing = False
            return another
        if self.playing:
            self.share = min(self.share + seconds / max(motion.duration, 1e-6), 1.0)
            self.playing = self.share < 1.0
        self._move_to(motion.at(self.share * motion.duration).q)
        return another

    @property
    def sentence(self) -> str:
        """The status of the plan as the page shows it; empty if it does not plan."""
        if not self.on:
            return ""
        if self.waiting:
            return "waiting for the planner to compile"
        if self.shown is None:
            return "no goal yet: drag the handles of the goal"
        plan, motion = self.shown.plan, self.shown.motion
        at = f"waypoint {self.shown.n_reached + 1}: " if motion is None and self.shown.n_reached < len(self.waypoints) else ""
        return at + self._sentence_of(self.shown, plan, motion)

    def _sentence_of(self, shown: PlannedMotion, plan: Plan, motion: Trajectory | None) -> str:
        if isinstance(plan.reason.data, Report):
            hits = [pair for pair in plan.reason.data.pairs if pair.signed_distance <= 0.0]
            own = plan.status == PlanStatus.START_IN_COLLISION and all(pair.link_b is not None for pair in hits)
            hint = "; if these links touch in every pose, allow these contacts" if own else ""
            return f"{plan.status}: {self._session.names.list_pairs(hits)}{hint}"
        if motion is None:
            of = plan.reason.data
            return f"{plan.status}: {_describe_error(of)}" if isinstance(of, IKResult) else str(plan)
        how = "certified free" if motion.certified else "not certified"
        if self.upright or self.on_line:
            how += f", uses at most {plan.worst_violation:.0%} of the tolerance"
        if len(shown.legs) > 1:
            return f"{plan.status}: a motion of {motion.duration:.2f} s, {how}, in {len(shown.legs)} parts"
        too = f"; no path was found without moving {', '.join(plan.moved_beside)} too" if plan.moved_beside else ""
        return f"{plan.status}: a motion of {motion.duration:.2f} s, {how}, {count_of(plan.checks, 'edge')} checked{too}"

    def start_here(self) -> None:
        """Plan from the present configuration."""
        self._begin(self._goal, self.waypoints, on=self.on)

    def _begin(self, goal: Array | None, waypoints: tuple[Waypoint, ...], *, on: bool) -> None:
        """Plan to a goal from the present configuration.

        All fields are stored together at the end, without a call in between, so that an interrupt cannot split the change.
        """
        link, q = self._session.link, self._session.q
        self.on, self._goal, self.waypoints, self._link, self._start = on, goal, waypoints, link, q
        self._own_configurations = (q,)
        self.playing, self.share, self.shown, self.waiting, self._request = False, 0.0, None, False, None

    def _plan(self) -> bool:
        stops = self.waypoints if self._goal is None else (*self.waypoints, Waypoint(self._goal, moves_gripper=True))
        if not stops:
            return False
        session, settings = self._session, self.settings
        request = ([(stop.goal.tobytes(), *stop[1:]) for stop in stops], session.world.objects(), settings, session.robot)
        if request == self._request:
            return False
        start, share = (session.q, 0.0) if self.playing else (self._start, self.share)
        found = session.ask(NAME, plan_motion, session.robot, start, stops, session.world, settings)
        self._start, self.share, self.waiting, self.shown = start, share, found is None, found
        self._request = None if found is None else request
        return True

    def _move_to(self, q: Array) -> None:
        before = self._session.q
        if not np.array_equal(q, before):
            self._own_configurations = before, q
            self._session.q = q
        self._own_configurations = (q,)


def _describe_error(nearest: IKResult) -> str:
    """The error of the nearest configuration to a pose out of reach, in words."""
    parts = [f"{nearest.position_error * 1e3:.1f} mm"] if nearest.position_error >= 5e-5 else []
    if nearest.rotation_error >= np.radians(0.05):
        parts.append(f"{np.degrees(nearest.rotation_error):.1f} deg")
    return f"the nearest pose is {' and '.join(parts) or 'less than 0.1 mm'} away"
