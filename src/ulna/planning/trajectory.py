"""Defines a trajectory: its evaluation, samples for a controller, checks, files and plots."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World, refuse_no_world
from ulna.description.arrays import as_floats, as_number, positive
from ulna.description.file_bytes import write_table
from ulna.errors import FileError, InputError, cited, did_you_mean, needs_extra, reason_of
from ulna.kinematics.tree import Tree
from ulna.notebook.recording import Recording, drawer
from ulna.notebook.tables import OneLine, table
from ulna.planning.arm_limits import ArmLimits
from ulna.planning.blend import CHORDS, Grid
from ulna.planning.boundary_velocities import Ends, refuse_path_beyond
from ulna.planning.constraint_table import as_keeps, make_constraint_table
from ulna.planning.hand import UNITS, Hand, HandLimits, HandPeak, peak_of
from ulna.planning.keep import Keep
from ulna.planning.motion import Motion
from ulna.planning.motion_check import MotionCheck, Samples, check_of
from ulna.planning.motion_limits import GivenLimits, as_limits, limit_to_robot, limits_of
from ulna.planning.motors import Motors, as_caps
from ulna.planning.path_limits import PathLimit, common_to, peaks_of
from ulna.planning.positions import PositionLimits
from ulna.planning.ros_message import joint_trajectory, message_points
from ulna.planning.timing import QUANTITIES, Limits, Moment, Profile, TimedPath
from ulna.planning.transition import JoinedMotion, Timed, is_from_file, switch_path

if TYPE_CHECKING:
    from ulna.planning.plan import Plan

Array = NDArray[np.float64]
_MAX_SAMPLES = 10_000_000
_UNITS = "rad or m", "1/s", "1/s²", "1/s³"  # units of a plot
_TABLE_SAMPLES = 1000  # samples from which a notebook's table takes the largest velocities
_PLOT_RANGE = 1.5  # limits beyond this multiple of the largest value are not drawn
_JOIN_TOLERANCE = 1e-6  # [rad or m]: largest distance between joined motions


class ReadsMotions(Protocol):
    """The interface of a robot that reads its motions from files."""

    def motion_from_file(self, path: str | Path, *, others: ArrayLike | None = None) -> Trajectory:
        """Read a motion; see ``Robot.motion_from_file``."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(OneLine):
    """A motion in time within limits, from rest to rest unless velocities at its ends were given.

    Without jerk limits, the path between two grid points is a line or a parabola, passed with constant path acceleration. With
    jerk limits, the trajectory is a moving average of such a motion, or follows lines with piecewise constant jerk. ``at``
    evaluates it exactly, without interpolation.

    Attributes:
        certified: Whether the whole motion is certified to be free, including its rounded corners.
        joint_names: The names of the entries of q.
    """

    certified: bool
    joint_names: tuple[str, ...]
    _timed: Timed
    _motion: Motion | None = field(default=None, repr=False)
    _limits: Limits | None = field(default=None, repr=False)
    _ends: Ends | None = field(default=None, repr=False)
    _positions: PositionLimits | None = field(default=None, repr=False)
    _caps: tuple[PathLimit, ...] = field(default=(), repr=False)

    @staticmethod
    def from_file(path: str | Path, robot: ReadsMotions, *, others: ArrayLike | None = None) -> Trajectory:
        """Read a motion from a file, to check it, send it, or compute new times: ``robot.trajectory(motion, ...)``.

        It reads a ``trajectory_msgs/JointTrajectory``, or a message that contains one, such as a plan of MoveIt, in YAML or JSON.
        It also reads tables with times (.csv, .npy), such as ``to_csv`` writes. Points are interpolated as in ros2_control: by
        polynomials of degree five between points with accelerations, of degree three between points with velocities, else by
        lines. The motion begins at its first point. It is not certified.

        Args:
            path: The file: ``.yaml``, ``.yml`` and ``.json`` are messages, any other is a table.
            robot: The robot. Joints are matched by name, in any order; unknown joints are ignored.
            others: The configuration that gives joints the file does not name [rad or m], shape (n_dof,). Unless given, the file
                must name all joints.

        Returns:
            A ``Trajectory`` with the limits of the robot.

        Raises:
            FileError: The file cannot be read, or is too long.
            DescriptionError: The file has no such message, or an incomplete one.
            InputError: A table has other columns, or times that do not increase.

        Example:
            >>> import tempfile, ulna
            >>> robot = ulna.load("panda")
            >>> motion = robot.trajectory([robot.home, robot.home + 0.3], acceleration=5.0)
            >>> with tempfile.TemporaryDirectory() as folder:
            ...     motion.to_csv(f"{folder}/motion.csv")
            ...     again = ulna.Trajectory.from_file(f"{folder}/motion.csv", robot)
            >>> again.duration == motion.duration
            True
        """
        return robot.motion_from_file(path, others=others)

    def __post_init__(self) -> None:
        for array in self._ends or ():
            array.setflags(write=False)

    @cached_property
    def times(self) -> Array:
        """The times of the grid points, or of the changes of jerk [s], shape (n,)."""
        return _read_only(self._timed.times if self.duration else np.zeros(1))

    @property
    def q(self) -> Array:
        """Positions at ``times`` [rad or m], shape (n, n_dof)."""
        return self._at_times.q

    @property
    def qd(self) -> Array:
        """Velocities at ``times`` [rad/s or m/s], shape (n, n_dof)."""
        return self._at_times.qd

    @property
    def qdd(self) -> Array:
        """Accelerations just after each of ``times`` [rad/s^2 or m/s^2], shape (n, n_dof); just before the last one."""
        return self._at_times.qdd

    @cached_property
    def _at_times(self) -> Moment:
        return Moment(*map(_read_only, self._timed.at(self.times)))

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return self._timed.duration

    @property
    def stops(self) -> int:
        """The number of corners at which the motion stops."""
        return len(self.rests) - 2

    @property
    def rests(self) -> Array:
        """The times at rest [s], shape (stops + 2,): the start, each stop, and the end."""
        return self._timed.rests

    @property
    def end_velocities(self) -> Array:
        """The velocities at the start and at the end [rad/s or m/s], shape (2, n_dof): exactly 0 at rest."""
        return np.zeros((2, self.q.shape[1])) if self._ends is None else np.array(self._ends)

    @property
    def limits_jerk(self) -> bool:
        """Whether the acceleration is continuous, as in a motion made with ``jerk=``."""
        return self._timed.limits_jerk

    @property
    def limits(self) -> dict[str, tuple[Array, Array]]:
        """The known lower and upper limits of "position", "velocity", "acceleration" and "jerk", shape (n_dof,) each."""
        known = {} if self._positions is None else {"position": (self._positions.lower, self._positions.upper)}
        most = zip(QUANTITIES[1:], self._limits or (), strict=False)
        return known | {name: (-each, each) for name, each in most if each is not None}

    @property
    def hand_limits(self) -> tuple[HandLimits, ...]:
        """The limits of hands that the motion was made with, each with the name of its link."""
        return tuple(cap.limits for cap in self._caps if isinstance(cap, Hand))

    def at(self, t: ArrayLike) -> Moment:
        """Positions, velocities and accelerations at times.

        Args:
            t: Times [s], shape (...). Before 0 and after ``duration`` the arm rests, or continues straight with its end velocity.

        Returns:
            A ``Moment`` (q, qd, qdd), shape (..., n_dof) each.

        Raises:
            InputError: t is not an array of finite numbers.
        """
        t = as_floats("t", t)
        if not np.isfinite(t).all():
            raise InputError("t", "finite times [s] are expected")
        within = np.clip(t, 0.0, self.duration)
        moment, outside = self._timed.at(within), (t != within)[..., None]
        q, qd = moment.q, 0.0
        if self._ends is not None:
            qd = np.where((t < 0.0)[..., None], *self._ends)
            q = q + (t - within)[..., None] * qd
        return Moment(q, np.where(outside, qd, moment.qd), *(np.where(outside, 0.0, each) for each in moment[2:]))

    def is_free(
        self, world: World | None, *, since: float = 0.0, clearance: float = 0.0, keep: Keep | Iterable[Keep] = ()
    ) -> bool:
        """Whether the motion, from a time on, is certified to be free in another world.

        The lines and parabolas of the motion are checked. False need not mean a contact: a motion near an object may be free but
        not certified.

        Args:
            world: The obstacles; none for None.
            since: The start of the checked part [s]; the last configuration is always checked.
            clearance: The minimum distance from objects [m].
            keep: Constraints to check too. A constraint without a pose refers to the start of the whole motion. The constraints
                of the plan are not checked unless given, since they do not depend on the world.

        Raises:
            InputError: ``since`` or ``clearance`` is not a finite number of at least 0, the world is not a ``World``, or a
                constraint is invalid.
            UnknownNameError: A constraint names an unknown link.
            GeometryError: The world has shapes that cannot be checked.
        """
        since = as_number("since", since, 0.0, "a time [s] of at least 0")
        clearance = as_number("clearance", clearance, 0.0, "a distance [m] of at least 0")
        refuse_no_world(world)
        if self._motion is None:
            raise AssertionError("every plan with a path has one")
        tree = self._motion.checker.tree
        keeps = make_constraint_table(as_keeps(keep, tree, self.q[0]), tree)
        points, spreads = self._timed.edges_since(min(since, self.duration))
        return self._motion._replace(world=world, margin=clearance, keeps=keeps).is_free(points, spreads)

    def sampled(self, period: float = 0.001) -> Samples:
        """Samples for a controller: positions, velocities and accelerations once per period.

        Times are whole periods from 0. The last sample is the first one not before ``duration``. Its q is exactly
        ``self.q[-1]``, and its velocity and acceleration are exactly 0. So the arm arrives less than a period after ``duration``.
        A motion with a velocity at its end continues straight until the last sample.

        Args:
            period: The time between two samples [s].

        Returns:
            ``Samples``: t [s], shape (n,); q, qd and qdd, shape (n, n_dof) each.

        Raises:
            InputError: ``period`` is not above 0, or there would be more than 10^7 samples.
        """
        t = np.arange(self._count_of_periods(period) + 1, dtype=np.float64) * period
        q, qd, qdd = self.at(t)[:3]
        end = self.end_velocities[1]
        q[-1], qd[-1], qdd[-1] = self.q[-1] + (t[-1] - self.duration) * end, end, 0.0
        return Samples(t, q, qd, qdd)

    def check(
        self,
        limits: GivenLimits | None = None,
        *,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
        hand: HandLimits | Iterable[HandLimits] | None = None,
        torque: ArrayLike | None = None,
        period: float = 0.001,
    ) -> MotionCheck:
        """Check whether a controller accepts the motion: positions, and finite differences of its samples.

        As in libfranka, velocities are differences of positions divided by the period, accelerations are differences of
        velocities, and jerks are differences of accelerations. Before the first sample and after the last, the arm rests or
        continues straight with its end velocity. The velocity limits of an FR3, and of ``limits="fr3"``, depend on the position.

        Args:
            limits: The name of an arm, as "franka", or a file ``joint_limits.yaml`` or its mapping: ``docs/trajectories.md``. A
                velocity or a position that it does not have is the description's. If no limits are given, the limits that the
                motion was made with.
            velocity: Maximum velocity [rad/s or m/s], a number or n_dof numbers, in place of the velocity of ``limits``.
            acceleration: Maximum acceleration [rad/s^2 or m/s^2].
            jerk: Maximum jerk [rad/s^3 or m/s^3].
            hand: Maximum speed and acceleration of the hand, or of several links; the ones that the motion was made with unless
                given. They are checked at all times, also between samples.
            torque: Maximum torque of each joint [Nm or N], a number or n_dof numbers; True for the effort limits of the
                description, False for no limit. Unless given, the ones that the motion was made with.
            period: The time between two samples [s].

        Returns:
            A ``MotionCheck``, true if the motion is within the limits; ``print`` shows it as a sentence. Positions are checked at
            all times: the extreme position of each joint is exact, also between samples.

        Raises:
            InputError: A limit or ``period`` is invalid, or no limit is known.
            UnknownNameError: There is no such set of limits.
            FileError: The file cannot be read.
            DescriptionError: The file has no valid limits.
        """
        samples, n, positions = self.sampled(period), self.q.shape[1], self._positions
        arm = ArmLimits(np.full(n, np.inf), None, None, "")
        if limits is not None:
            tree = None if self._motion is None else self._motion.checker.tree
            arm = limits_of(limits, self.joint_names, None if tree is None else tree.followers, ())
            arm, positions = (arm, positions) if tree is None else limit_to_robot(arm, tree)
        elif velocity is None and acceleration is None and jerk is None and (hand is None or self._limits is not None):
            if self._limits is None:
                raise InputError("limits", "no limits are given, and this motion has none")
            arm = ArmLimits(*self._limits, "")
        given = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk}
        arm = arm._replace(
            **{name: as_limits(name, most, n, may_be_infinite=True) for name, most in given.items() if most is not None}
        )
        judged = check_of(samples, float(period), arm, self.joint_names, self.end_velocities)
        judged = judged.with_peaks(peaks_of(self._timed, self._given_caps(hand, torque)))
        beyond = None if positions is None else positions.beyond(self._timed)
        return judged if beyond is None else judged.beyond_position(beyond, self.joint_names)

    def hand_peak(self, link: str | None = None, quantity: str = "speed") -> HandPeak:
        """The peak speed of a link's origin in the motion and its time; or the peak of another quantity.

        Args:
            link: The link; the robot's tip unless given.
            quantity: "speed" or "acceleration" of its origin, or "angular_speed".

        Returns:
            A ``HandPeak``; ``print`` shows it as a sentence. Its ``bound`` holds at all times.

        Raises:
            InputError: There is no such quantity, or there are several tips and no link is named.
            UnknownNameError: There is no such link.

        Example:
            >>> import ulna
            >>> robot = ulna.load("panda")
            >>> motion = robot.trajectory([robot.home, robot.home + 0.3], acceleration=5.0)
            >>> print(motion.hand_peak())
            the speed of panda_ee peaks at 1.364 m/s at 0.245 s
        """
        if quantity not in UNITS:
            raise InputError("quantity", f"{cited(quantity)} is no quantity of a hand{did_you_mean(str(quantity), UNITS)}")
        return peak_of(self._timed, self._tree, link, quantity)

    @property
    def _tree(self) -> Tree:
        if self._motion is None:
            raise AssertionError("every plan with a path has one")
        return self._motion.checker.tree

    def slowed(self, factor: float) -> Trajectory:
        """A slower motion along the same configurations: at time t it is where this one is at ``factor`` times t.

        Velocities are scaled by ``factor``, accelerations by factor^2, jerks by factor^3. It is certified if this motion is.

        Args:
            factor: A number from 1e-6 to 1: 0.5 takes twice as long.

        Raises:
            InputError: ``factor`` is not such a number.
        """
        factor = as_number("factor", factor, 1e-6, "a number from 1e-6 to 1: a faster motion needs a new trajectory", most=1.0)
        if not self.duration:
            return self
        timed, names, ends = self._timed.slowed(factor), self.joint_names, Ends(*(factor * self.end_velocities))
        return Trajectory(self.certified, names, timed, self._motion, self._limits, ends, self._positions, self._caps)

    def replace(self, plan: Plan, *, at: float) -> Trajectory:
        """Switch to another plan while this motion is running.

        The result equals this motion until ``at``. Then velocities stay continuous, and with a jerk limit accelerations too. It
        stays within the limits of this motion at all times. From ``at`` on, all of it is certified to be free in the plan's
        world.

        The motion continues straight for the distance that it needs, and then goes to the second point of the plan's path. If
        that is not free, it brakes along this motion's path, which is free. From the stop it goes to the plan's path, or back to
        the path's start.

        Args:
            plan: A plan whose path begins where this motion is at ``at``: ``robot.plan(motion.at(t).q, goal, world)``.
            at: The time of the switch [s], from 0 to ``duration``.

        Returns:
            A ``Trajectory`` with the same times up to ``at``.

        Raises:
            InputError: The plan has no path or begins elsewhere; ``at`` is not within the motion; or no transition to the plan is
                certified to be free.
        """
        at = as_number("at", at, 0.0, "a time [s] within the motion")
        if at > self.duration:
            raise InputError("at", f"{at!r}; the motion takes {self.duration:.4g} s")
        from ulna.planning.plan import Plan  # noqa: PLC0415 - it imports this file

        if not isinstance(plan, Plan):
            raise InputError("plan", f"{type(plan).__name__}; an ulna.Plan is expected, as robot.plan returns")
        motion = plan._motion  # noqa: SLF001 - a plan and its trajectory belong together
        if not plan or motion is None:
            raise InputError("plan", f"there is no path: {plan.status}")
        if self._limits is None or is_from_file(self._timed):
            reason = "this motion has no limits"
            if self._limits is not None:
                reason = "a motion from a file cannot be replaced; robot.trajectory(motion, ...) computes new times within limits"
            raise InputError("limits", reason)
        here = self.at(at).q
        if plan.path.shape[1] != len(here) or np.abs(plan.path[0] - here).max() > _JOIN_TOLERANCE:
            raise InputError(
                "plan", f"its path does not begin where the motion is at {at:.6g} s; plan from motion.at({at:.6g}).q"
            )
        tree, ends, names = motion.checker.tree, Ends(self.end_velocities[0], np.zeros_like(here)), self.joint_names
        positions = PositionLimits(tree.lower, tree.upper).narrowed(self._positions)
        refuse_path_beyond("plan", plan.path, positions, names)
        caps = tuple(cap.with_dynamics(motion.dynamics) for cap in self._caps)
        is_free = motion.certificate._replace(positions=positions, caps=caps)
        path = plan.path if self._limits.jerk is None else motion.subdivide(plan.path, positions)
        timed = switch_path(self._timed, path, at, self._limits, is_free)
        return Trajectory(self.certified, names, timed, motion, self._limits, ends, self._positions, caps)

    def then(self, other: Trajectory) -> Trajectory:
        """Join this motion and another motion that begins where this one ends, with a stop between them.

        The result is certified if both motions are. Of two different limits it has the wider ones. It has limits of hands and of
        torques only if both motions have the same.

        Args:
            other: A motion of the same joints, as ``robot.plan(motion.q[-1], goal, world).trajectory(...)``.

        Raises:
            InputError: ``other`` has other joints or begins elsewhere, or a motion is not at rest at the junction.

        Example:
            >>> import ulna
            >>> robot = ulna.load("panda")
            >>> there = robot.trajectory([robot.home, robot.home + 0.3], acceleration=5.0)
            >>> both = there.then(robot.trajectory([robot.home + 0.3, robot.home], acceleration=5.0))
            >>> both.stops, both.duration == 2 * there.duration
            (1, True)
        """
        if not isinstance(other, Trajectory) or other.joint_names != self.joint_names:
            raise InputError("other", f"{cited(other)}; a motion of the same joints is expected")
        if np.abs(other.q[0] - self.q[-1]).max(initial=0.0) > _JOIN_TOLERANCE:
            raise InputError("other", "its start differs from the end of this motion; plan from motion.q[-1]")
        ends = Ends(self.end_velocities[0], other.end_velocities[1])
        if np.any([self.end_velocities[1], other.end_velocities[0]]):
            raise InputError("other", "both motions must be at rest where they are joined")
        if not self.duration or not other.duration:
            return other if not self.duration else self
        limits = None if self._limits is None or other._limits is None else self._limits.wider(other._limits)
        positions = None if self._positions is None or other._positions is None else self._positions.wider(other._positions)
        certified, timed = self.certified and other.certified, JoinedMotion(self._timed, other._timed)
        caps = common_to(self._caps, other._caps)
        return Trajectory(certified, self.joint_names, timed, self._motion, limits, ends, positions, caps)

    def torques(self, t: ArrayLike) -> Array:
        """The torques that the motion needs at times, with gravity and attached objects.

        Args:
            t: Times [s], shape (...).

        Returns:
            Torques [Nm or N], shape (..., n_dof).

        Raises:
            InputError: t is not an array of finite numbers, or the robot of the motion is unknown.
            InertiaError: A moving link has a shape but no inertia.
        """
        if self._motion is None or self._motion.dynamics is None:
            raise InputError("motion", "its robot is unknown")
        return self._motion.dynamics.inverse(self.at(t)[:3], None, None, None)

    def _given_caps(self, hand: HandLimits | Iterable[HandLimits] | None, torque: ArrayLike | None) -> tuple[PathLimit, ...]:
        """The given limits of hands and torques, or the ones that the motion was made with."""
        if hand is None and torque is None:
            return self._caps
        dynamics = None if self._motion is None else self._motion.dynamics
        given = as_caps(hand, torque, self._tree, dynamics)
        kind = (Hand,) * (hand is None) + (Motors,) * (torque is None)
        return (*given, *(cap for cap in self._caps if isinstance(cap, kind)))

    def _count_of_periods(self, period: float) -> int:
        """The number of periods of the motion, rounded up."""
        with np.errstate(over="ignore"):
            n = np.ceil(np.float64(self.duration) / positive("period", period, "a time [s] above 0") * (1 - 1e-12))
        if n > _MAX_SAMPLES:
            raise InputError("period", f"{period!r}; a motion of {self.duration:.4g} s would have {n:.3g} samples")
        return int(n)

    def to_csv(self, path: str | Path, *, period: float | None = None) -> None:
        """Write a table: a line of names, then a line for each time, with q, qd and qdd.

        Args:
            path: The file's name.
            period: The time between two lines [s]; the end is added. Unless given, one line for each of ``times``.

        Raises:
            InputError: ``period`` is not above 0, or there would be more than 10^7 lines.
            FileError: The file cannot be written.
        """
        t = self.times
        if period is not None:
            self._count_of_periods(period)
            t = np.append(np.arange(0.0, self.duration, period), self.duration)
        moment = self.at(t)[:3]
        names = [f"{kind}{name}" for kind in ("", "velocity_", "acceleration_") for name in self.joint_names]
        write_table(path, ["time", *names], np.column_stack([t, *moment]))

    def to_json(self, path: str | Path, *, period: float = 0.01) -> None:
        """Write the message of ``to_ros`` as JSON, without ROS; ``robot.motion_from_file`` and ROS tools read it.

        Args:
            path: The file's name; it should end in ``.json``.
            period: The maximum time between two points [s]; points are spaced evenly from rest to rest.

        Raises:
            InputError: ``period`` is not above 0, or there would be more than 10^7 points.
            FileError: The file cannot be written.
        """
        self._count_of_periods(period)
        columns = list(range(len(self.joint_names)))
        points = [
            {
                "positions": q,
                "velocities": qd,
                "accelerations": qdd,
                "time_from_start": dict(zip(("sec", "nanosec"), time, strict=True)),
            }
            for time, q, qd, qdd in message_points(self.at, self.rests, self.end_velocities, columns, period)
        ]
        try:
            Path(path).write_text(json.dumps({"joint_names": self.joint_names, "points": points}), encoding="utf-8")
        except OSError as error:
            raise FileError(str(path), reason_of(error, missing="no such folder")) from None

    def to_ros(self, joint_names: Sequence[str] | None = None, *, period: float = 0.01) -> Any:
        """Make a ``trajectory_msgs/JointTrajectory`` message of the installed ROS, 1 or 2.

        Its stamp is zero, so the controller starts at once. The first point is the start, at time 0. Velocities at both ends are
        0 unless the motion moves there. Each stop on the path is also a point, with velocity and acceleration 0. Otherwise a
        controller would round the corner, since it interpolates between points.

        Args:
            joint_names: The joints of the message in order, such as the joints of one controller; all unless given.
            period: The maximum time between two points [s]; points are spaced evenly from rest to rest.

        Raises:
            InputError: ``period`` is not above 0; no joint is named, or a joint is named twice.
            UnknownNameError: There is no such joint.
            MissingROSError: ``trajectory_msgs`` cannot be imported.
        """
        names = self.joint_names if joint_names is None else joint_names
        return joint_trajectory(self.at, self.rests, self.end_velocities, self.joint_names, names, period)

    def plot(self):
        """Plot positions, velocities and accelerations over time, as a Matplotlib figure.

        Jerks, torques and the speeds of hands are plotted too, if they are limited. Known limits near the curves are dashed lines
        in the color of the joint. A notebook shows the figure in the last line of a cell; ``figure.savefig("motion.png")`` writes
        it. No window opens.

        Raises:
            MissingExtraError: Matplotlib is not installed.
        """
        with needs_extra("a plot", "plot", "matplotlib"):
            from ulna.notebook.figure import NotebookFigure  # noqa: PLC0415 - it needs the extra
        t, limits = np.linspace(0.0, self.duration, 1000), self.limits
        moment, hands = self.at(t), [cap for cap in self._caps if isinstance(cap, Hand) and cap.limits.speed is not None]
        n, shown = 4 if self.limits_jerk else 3, list[tuple[str, str, Array]]()
        shown.extend(zip(QUANTITIES[:n], _UNITS[:n], moment[:n], strict=True))
        for motors in (cap for cap in self._caps if isinstance(cap, Motors)):
            shown.append(("torque", "Nm or N", motors.torques(*moment[:3])))
            limits["torque"] = -motors.most, motors.most
        n_rows = len(shown) + bool(hands)
        figure = NotebookFigure(figsize=(8, 2.6 * n_rows), layout="constrained")
        rows = figure.subplots(n_rows, sharex=True)
        for hand in hands:
            (line,) = rows[-1].plot(t, np.linalg.norm(hand.velocities(moment.q, moment.qd)[0], axis=1), label=hand.link)
            rows[-1].axhline(hand.limits.speed, color=line.get_color(), linestyle="dashed", linewidth=0.8)
            rows[-1].set_ylabel("speed [m/s]")
            rows[-1].legend(fontsize="small")
        for axes, (name, unit, values) in zip(rows, shown, strict=False):
            lines = axes.plot(t, values, label=self.joint_names)
            axes.set_ylabel(f"{name} [{unit}]")
            reach = _PLOT_RANGE * np.abs(values).max()
            for ends in limits.get(name, ()):
                for line, end in zip(lines, ends, strict=True):
                    if abs(end) <= reach:
                        axes.axhline(end, color=line.get_color(), linestyle="dashed", linewidth=0.8)
        figure.axes[0].legend(fontsize="small", ncols=2)
        figure.axes[-1].set_xlabel("time [s]")
        return figure

    def show(
        self,
        world: World | None = None,
        *,
        seconds: float | None = None,
        boxes: bool = False,
        size: tuple[int, int] | None = None,
        camera: str | ArrayLike | None = None,
    ) -> Recording:
        """Draw an animation of the motion without a display; a notebook loops it and stores it in its file.

        Args:
            world: The obstacles, red where they are touched; the obstacles of the plan unless given.
            seconds: The length of the animation [s]; the duration of the motion, at most 10, unless given.
            boxes: Show the robot's collision shapes, except meshes.
            size: Width and height [pixels]; 480 and 320 unless given.
            camera: Where the robot is seen from; see ``Robot.show``.

        Returns:
            A ``Recording``; its ``save("motion.mp4")`` writes a video, ``save("motion.gif")`` an animated GIF.

        Raises:
            InputError: The world, the seconds, the size or the camera is invalid.
            MissingExtraError: The extra ``viewer`` is not installed.
        """
        if self._motion is None:
            raise AssertionError("every plan with a path has one")
        around = self._motion.world if world is None else world
        return drawer("motion")(self, self._motion.checker, around, seconds=seconds, boxes=boxes, size=size, camera=camera)

    def __getstate__(self) -> dict:
        return {name: value for name, value in self.__dict__.items() if name not in {"times", "_at_times"}}

    def __setstate__(self, state: dict) -> None:
        self.__dict__.update(state)
        self.__post_init__()

    def _repr_html_(self) -> str:
        t = np.linspace(0.0, self.duration, _TABLE_SAMPLES)
        q, qd, qdd = self.at(t)[:3]
        time_optimal, hardest = (np.abs(each).max(axis=0) for each in (qd, qdd))
        columns = (each.tolist() for each in (q[0], q[-1], time_optimal, hardest))
        headers = "joint", "start", "end", "largest velocity", "largest acceleration"
        return table(repr(self)[1:-1], headers, zip(self.joint_names, *columns, strict=True), ["in rad and s; m for slides"])

    def __str__(self) -> str:
        how = "certified free" if self.certified else "not certified"
        stops = f"{self.stops} stop{'s' * (self.stops != 1)} on the way"
        return f"{self.duration:.4g} s, {len(self.times)} grid points, {stops}, {how}"

    def __repr__(self) -> str:
        n = len(self.joint_names)
        how = "certified free" if self.certified else "not certified"
        return f"<Trajectory: {self.duration:.4g} s, {n} joint{'s' * (n != 1)}, {how}>"


def _read_only(array: Array) -> Array:
    array = array.view()
    array.setflags(write=False)
    return array


def trajectory_at_rest(
    q: Array, joint_names: tuple[str, ...], *, certified: bool, motion: Motion, limits: Limits, positions: PositionLimits
) -> Trajectory:
    """The trajectory of a plan without motion."""
    none, zero = np.zeros((1, len(q))), np.zeros(1)
    grid = Grid(q[None].copy(), none, none, zero, np.array([0, 0]), CHORDS)
    timed = TimedPath(grid, Profile(np.zeros(2), zero, zero, zero))
    return Trajectory(certified, joint_names, timed, motion, limits, None, positions)
