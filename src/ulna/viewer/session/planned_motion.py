"""Plans the motion of a view's arm to a goal, samples it as curves to plot, and moves the arm along it."""

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
from ulna.viewer.session.way import Leg, Manner, Waypoint, gripper_of, joined, way_through

NAME = "planning a motion"
JERK = 30.0  # [rad/s^3 or m/s^3] of every joint, where it is limited
_POINTS = 200  # of the line that is drawn
_SAMPLES = 400  # of a curve
Array = NDArray[np.float64]


Aims = tuple[Array | None, tuple[Waypoint, ...]]


@dataclass(frozen=True, eq=False)
class Curve:
    """One quantity of a motion over time.

    Attributes:
        t: Times [s], shape (n,).
        values: The quantity of each entry of q, in radians or meters and seconds, shape (n, n_dof).
        low, high: Its limits, shape (n_dof,) each; infinite where there are none.
    """

    t: Array
    values: Array
    low: Array
    high: Array

    @property
    def shares(self) -> Array:
        """The values from -1 at the lower limit to 1 at the upper one, shape (n, n_dof); NaN where there are no limits."""
        with np.errstate(invalid="ignore", divide="ignore"):
            middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
            return np.where(np.isfinite(half) & (half > 0.0), (self.values - middle) / half, np.nan)


@dataclass(frozen=True, eq=False)
class Planned:
    """A plan as it is shown.

    Attributes:
        plan: The plan.
        motion: Its motion in time; None if there is no path.
        line: The positions of the hand along the motion [m], shape (n, 3).
        end: The last configuration of the path, shape (n_dof,). Without a path it is the goal, or a configuration as near to the
            goal's pose as inverse kinematics without a world comes.
        curves: What is plotted of the motion; empty without one.
        kept_line: The ends of the line that is kept [m], shape (2, 3); None if none is.
        legs: The motions of which it is made.
        n_reached: How many of the way points, and of the goal after them, are reached.
    """

    plan: Plan
    motion: Trajectory | None
    line: Array
    end: Array
    curves: dict[str, Curve] = field(default_factory=dict)
    kept_line: Array | None = None
    legs: tuple[Leg, ...] = ()
    n_reached: int = 0


def planned(robot: Robot, start: Array, stops: tuple[Waypoint, ...], world: World, manner: Manner) -> Planned:
    """A motion from a configuration through way points, of which the last is the goal."""
    legs, n_reached = way_through(robot, start, stops, world, manner)
    link, last, line, motion = manner.link, legs[-1], legs[-1].line, joined(legs)
    if motion is None:
        end, goal = last.goal, last.goal
        if goal.ndim == 2:
            of = last.plan.reason.data  # where the goal is out of reach, what is nearest to it: the sentence says how near
            held = manner.held
            near = of if isinstance(of, IKResult) else robot.inverse_kinematics(goal, last.start, link=link, held=held)
            end = near.q
        return Planned(last.plan, None, np.empty((0, 3)), end, kept_line=line, legs=tuple(legs), n_reached=n_reached)
    q = motion.at(np.linspace(0.0, motion.duration, _POINTS * len(legs))).q
    way = robot.forward_kinematics(q, link=link)[:, :3, 3]
    return Planned(last.plan, motion, way, motion.q[-1], curves_of(motion), line, tuple(legs), n_reached)


def curves_of(motion: Trajectory) -> dict[str, Curve]:
    """The curves of a motion by quantity; no jerk if it is not limited: then the acceleration has jumps."""
    t = np.linspace(0.0, motion.duration, _SAMPLES)
    values: dict[str, Array] = dict(zip(QUANTITIES, motion.at(t), strict=True))
    return {name: Curve(t, values[name], *ends) for name, ends in motion.limits.items()}


class Planning:
    """A goal, the motion to it from where the arm stood, and how much of it is done. Hold the session's lock around its methods.

    It plans anew when the goal or an obstacle was moved. When the arm was moved by other means, it plans from there.

    Attributes:
        on: Whether it plans.
        jerk: The greatest jerk of the motion [rad/s^3 or m/s^3]; None for no limit.
        upright: Whether what of the hand points up at the start is kept upright.
        on_line: Whether the hand is kept on the line to the goal.
        held: The joints that keep their positions, besides those of the session.
        waypoints: The goals through which it goes before the present one.
        shown: The plan; None without a goal, and while its kernels are compiled.
        waiting: Whether its kernels are being compiled.
        share: How much of the motion's time has passed, 0 to 1.
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
        self.shown: Planned | None = None
        self._goal: Array | None = None
        self._start = session.q
        self._placed = (session.q,)  # where it has put the arm; two while it does so
        self._asked: tuple | None = None
        self._link = session.link

    @property
    def target(self) -> None:
        """Nothing pulls the goal; see ``Session.target``."""

    @property
    def hand_pose(self) -> Array:
        """The goal of the hand, T_base_hand, shape (4, 4); where the hand is while there is no goal."""
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

    def send_to(self, q: ArrayLike) -> None:
        """Choose a configuration as the goal, shape (n_dof,)."""
        self._goal = as_floats("q", q).copy()

    def keep_goal(self, approach: float = 0.0, retract: float = 0.0, opening: float | None = None) -> None:
        """Add the goal as a way point, or the present configuration if there is no goal."""
        goal = self._session.q if self._goal is None else self._goal
        self.aims = None, (*self.waypoints, Waypoint(goal, approach, retract, opening))

    def drop_waypoint(self) -> None:
        """Leave the last way point out: it is the goal again, unless there is one."""
        if self.waypoints:
            *others, last = self.waypoints
            self.aims = (last.goal if self._goal is None else self._goal), (*others,)

    @property
    def has_gripper(self) -> bool:
        """Whether the hand has fingers that open."""
        return len(gripper_of(self._session.robot, self._session.link)) > 0

    def words_of(self, stop: Waypoint) -> str:
        """Where a way point is, and how it is approached and left."""
        T = stop.goal if stop.goal.ndim == 2 else self._session.robot.forward_kinematics(stop.goal, link=self._session.link)
        words = ", ".join(f"{value + 0.0:.3f}" for value in T[:3, 3].round(3)) + " m"
        for name, way in (("approach", stop.approach), ("retract", stop.retract)):
            words += f", {name} {1e3 * way:g} mm" if way else ""
        return words if stop.opening is None else f"{words}, gripper {100 * stop.opening:g} % open"

    @property
    def aims(self) -> Aims:
        """The goal, or None, and the way points before it."""
        return self._goal, self.waypoints

    @aims.setter
    def aims(self, aims: Aims) -> None:
        self._goal, self.waypoints = aims
        if self._goal is None and not self.waypoints:
            self.shown, self._asked = None, None

    @property
    def manner(self) -> Manner:
        """The manner in which it plans."""
        return Manner(self._session.link, (*self._session.held, *self.held), self.jerk, self.upright, self.on_line)

    def turn(self, *, on: bool) -> None:
        """Begin to plan, from where the arm is and without a goal; or end it."""
        self._begin(None, (), on=on)

    def play(self) -> None:
        """Move the arm along the motion, from its beginning if it is at the end; or stop it."""
        if self.playing or self.shown is None or self.shown.motion is None:
            self.playing = False
            return
        self.share, self.playing = (0.0 if self.share >= 1.0 else self.share), True

    def scrub(self, share: float) -> None:
        """Put the arm where it is when a share of the motion's time has passed, from 0 to 1."""
        self.share, self.playing = min(max(float(share), 0.0), 1.0), False

    def frame(self, seconds: float) -> bool:
        """Plan if something has changed, and move the arm on by a time [s]. Returns whether the plan is another."""
        if not self.on:
            return False
        q = self._session.q
        if self._session.link != self._link or not any(np.array_equal(q, placed) for placed in self._placed):
            self.start_here()
        another = self._plan()
        motion = None if self.shown is None else self.shown.motion
        if motion is None:
            self.playing = False
            return another
        if self.playing:
            self.share = min(self.share + seconds / max(motion.duration, 1e-6), 1.0)
            self.playing = self.share < 1.0
        self._place(motion.at(self.share * motion.duration).q)
        return another

    @property
    def sentence(self) -> str:
        """What there is to say of the plan; empty if it does not plan."""
        if not self.on:
            return ""
        if self.waiting:
            return "the plan waits for the compiler"
        if self.shown is None:
            return "no goal yet: drag the handles of the goal"
        plan, motion = self.shown.plan, self.shown.motion
        at = f"way point {self.shown.n_reached + 1}: " if motion is None and self.shown.n_reached < len(self.waypoints) else ""
        return at + self._sentence_of(self.shown, plan, motion)

    def _sentence_of(self, shown: Planned, plan: Plan, motion: Trajectory | None) -> str:
        if isinstance(plan.reason.data, Report):
            hits = [pair for pair in plan.reason.data.pairs if pair.signed_distance <= 0.0]
            own = plan.status == PlanStatus.START_IN_COLLISION and all(pair.link_b is not None for pair in hits)
            hint = "; if they touch wherever the robot is, allow these contacts" if own else ""
            return f"{plan.status}: {self._session.names.listed(hits)}{hint}"
        if motion is None:
            of = plan.reason.data
            return f"{plan.status}: {_short_of(of)}" if isinstance(of, IKResult) else str(plan)
        how = "certified free" if motion.certified else "not certified"
        if self.upright or self.on_line:
            how += f", {plan.worst_violation:.0%} of the tolerance used at most"
        if len(shown.legs) > 1:
            return f"{plan.status}: a motion of {motion.duration:.2f} s, {how}, in {len(shown.legs)} motions"
        too = f"; no path was found without moving {', '.join(plan.moved_beside)} too" if plan.moved_beside else ""
        return f"{plan.status}: a motion of {motion.duration:.2f} s, {how}, {count_of(plan.checks, 'edge')} checked{too}"

    def start_here(self) -> None:
        """Plan from where the arm is."""
        self._begin(self._goal, self.waypoints, on=self.on)

    def _begin(self, goal: Array | None, waypoints: tuple[Waypoint, ...], *, on: bool) -> None:
        """Plan to a goal from where the arm is. All is stored at last, with no call between, in case it is interrupted."""
        link, q = self._session.link, self._session.q
        self.on, self._goal, self.waypoints, self._link, self._start, self._placed = on, goal, waypoints, link, q, (q,)
        self.playing, self.share, self.shown, self.waiting, self._asked = False, 0.0, None, False, None

    def _plan(self) -> bool:
        stops = self.waypoints if self._goal is None else (*self.waypoints, Waypoint(self._goal, moves_gripper=True))
        if not stops:
            return False
        session, manner = self._session, self.manner
        asked = ([(stop.goal.tobytes(), *stop[1:]) for stop in stops], session.world.objects(), manner, session.robot)
        if asked == self._asked:
            return False
        start, share = (session.q, 0.0) if self.playing else (self._start, self.share)
        found = session.ask(NAME, planned, session.robot, start, stops, session.world, manner)
        self._start, self.share, self.waiting, self.shown = start, share, found is None, found
        self._asked = None if found is None else asked
        return True

    def _place(self, q: Array) -> None:
        before = self._session.q
        if not np.array_equal(q, before):
            self._placed = before, q
            self._session.q = q
        self._placed = (q,)


def _short_of(nearest: IKResult) -> str:
    """By how much a pose is missed that is out of reach."""
    parts = [f"{nearest.position_error * 1e3:.1f} mm"] if nearest.position_error >= 5e-5 else []
    if nearest.rotation_error >= np.radians(0.05):
        parts.append(f"{np.degrees(nearest.rotation_error):.1f} deg")
    return f"{' and '.join(parts) or 'less than 0.1 mm'} too far"
