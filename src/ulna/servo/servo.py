"""Steers an arm tick by tick: each command is certified together with a full stop after it (``servo.entries.tick``)."""

from collections.abc import Iterable, Mapping, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.objects import Objects, rows_of
from ulna.collision.world import World
from ulna.description.arrays import as_floats, as_number, as_switch, positive
from ulna.description.likely_units import degrees_in_words
from ulna.description.pose import as_one_pose
from ulna.dynamics.dynamics import Dynamics
from ulna.engine.records import Records, copied
from ulna.errors import InputError, UnknownNameError
from ulna.ik.problem import refuse_immovable
from ulna.kernels.layout import OBJECT
from ulna.kernels.servo.servo_records import (
    BRAKING,
    FOLLOWING,
    HANDS,
    LIMITED_BY_ACCELERATION,
    LIMITED_BY_POSITION,
    LIMITED_BY_TORQUE,
    LIMITED_BY_VELOCITY,
    NOT_CERTIFIED,
    OFF_COMMAND,
    POSITION,
    REFUSED,
    REST,
    START,
    VELOCITY,
    HandGoal,
    JointLimits,
    JointState,
    ServoSettings,
    ServoTables,
    TickReport,
)
from ulna.kinematics.frames import Frame, frame_pose, twist_in_base
from ulna.kinematics.groups import JointGroup, tip_of
from ulna.kinematics.jacobian import as_frame
from ulna.kinematics.positions import as_configuration, as_names, columns_of_joints, is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree, entry_names
from ulna.planning.hand import HandLimits
from ulna.planning.motion_limits import LARGEST, as_limits, described_limits
from ulna.planning.motors import Motors, as_motors
from ulna.planning.targets import limit_excess
from ulna.planning.timing import Limits
from ulna.servo.command import STATUS_OF, Command, Limiting
from ulna.servo.entries import tick as entries
from ulna.servo.hand_cap import are_slow, as_capped, pieces_of, share_of
from ulna.servo.motor_cap import are_driven, driven_jerks, reach_of, share_of_accelerations
from ulna.servo.servo_state import ROUNDING, ServoState

Array = NDArray[np.float64]
WITHIN = 1 - 1e-6  # share of the limits of velocity and acceleration, so that differences of commands keep them too
_MAX_RAMP = 0.1  # [s], to reach an acceleration within the limit of jerk: bounds the duration of a full stop
ESCAPE_MARGIN = 0.25  # share of one tick's travel at full acceleration: certified beside motions, so the arm can leave a stop
_MIN_RATE, _MAX_RATE = 1e-3, 1e5  # [Hz]: at higher rates the differences of commands are rounding errors
_DAMPING = 0.01
_STILL, _NO_HANDS = np.zeros(6), HandGoal.records(0)
_PULL = 1.0  # [1/s]: rate of the pull towards the posture
_MIN_WEIGHT, _MAX_WEIGHT = 1e-3, 1e3  # of a hand
Goal = ArrayLike | Mapping[str, ArrayLike | None]


class Request(NamedTuple):
    """Options of a servo, unvalidated; see ``Robot.servo``."""

    rate: float
    link: str | Sequence[str] | None
    weights: ArrayLike | None
    held: Iterable[str]
    group: JointGroup | None
    velocity: ArrayLike | None
    acceleration: ArrayLike | None
    jerk: ArrayLike | None
    clearance: float
    tracking_error: ArrayLike
    posture: ArrayLike | None
    hand: HandLimits | Iterable[HandLimits] | None
    torque: ArrayLike | None
    torque_rate: ArrayLike | None
    dynamics: Dynamics


class _Drivable(NamedTuple):
    """Limits of joints that the motors allow in one tick; cached, since a tick needs them several times."""

    of: ServoState
    """State before the tick."""
    limits: Records[JointLimits]
    share: float
    """Share of the accelerations that the motors allow."""
    motor: int
    """Entry of q whose motor limits the share."""


class Servo:
    """Steers an arm tick by tick; made by ``Robot.servo``. One thread at a time may use it.

    The state is the last command. ``start`` sets it, and each ``step`` moves it by one tick. An interrupt such as Ctrl-C never
    leaves a step half done.
    """

    def __init__(self, tree: Tree, checker: Checker, world: World | None, request: Request) -> None:
        """See ``Robot.servo``."""
        refuse_immovable(tree)
        n, group, velocity, self._capped = tree.n_dof, request.group, request.velocity, as_capped(request.hand, tree)
        if not _MIN_RATE <= positive("rate", request.rate) <= _MAX_RATE:
            raise InputError("rate", f"{request.rate!r}; {_MIN_RATE:g} to {_MAX_RATE:g} ticks a second are expected")
        clearance = as_number("clearance", request.clearance, 0.0, "a distance [m] of at least 0")
        aside = as_floats("tracking_error", request.tracking_error)
        if aside.shape not in {(), (n,)} or not ((aside >= 0) & (aside < np.inf)).all():
            raise InputError("tracking_error", f"{request.tracking_error!r}; a number of at least 0, or {n} of them, is expected")
        still = columns_of_joints(tree, as_names(request.held))
        if group is not None:
            still |= ~np.isin(np.arange(n), group.columns)
        if still.all():
            raise InputError("held", "all joints are held, so the servo would never move")
        if velocity is None and not (tree.velocity_limits[~still]).all():
            names = zip(entry_names(tree), tree.velocity_limits, still, strict=True)
            slow = ", ".join(name for name, most, is_held in names if not most and not is_held)
            advice = "velocity= gives one, where exporters wrote 0 for not known"
            raise InputError("robot", f"its description allows {slow} a velocity of 0, so a servo would never move; {advice}")
        speeds = as_limits("velocity", tree.velocity_limits if velocity is None else velocity, n, may_be_infinite=True)
        own = np.where(tree.velocity_limits == 0.0, np.inf, tree.velocity_limits)  # a 0 in the file means unknown
        accelerations, jerks = _accelerations_of(tree, request.acceleration, request.jerk, still)
        tick = 1.0 / float(request.rate)
        self._motors, self._driven = as_motors(request.torque, tree, request.dynamics, request.torque_rate), None
        if self._motors is not None and self._motors.limits_rates:
            jerks = driven_jerks(self._motors, tree, accelerations / tick if jerks is None else jerks)
        accelerations, ramp, least = _ramp_of(accelerations, jerks, tick)
        self._tree, self._checker, self._world = tree, checker, world
        link = tip_of(group) if request.link is None and group is not None else request.link
        self._links: tuple[str, ...] = (
            (tree.link_or_tip(link),) if link is None or isinstance(link, str) else as_names(link, "link", "links")
        )
        self._chains, self._hands = _chains_and_hands(tree, self._links, request.weights)
        limits, settings = JointLimits.records(n), ServoSettings.records()
        limits["lower"], limits["upper"] = tree.lower_finite, tree.upper_finite
        limits["speed"] = np.where(still, 0.0, np.minimum(WITHIN * speeds, np.minimum(LARGEST, WITHIN * own)))
        limits["acceleration"], limits["tracking_error"] = accelerations, aside
        limits["jerk"], limits["escape_margin"] = 0.0 if jerks is None else jerks, np.where(still, 0.0, ESCAPE_MARGIN * least)
        one = settings[0]
        one.period, one.clearance, one.damping, one.ramp, one.lag = tick, clearance, _DAMPING**2, ramp, tick * (1 + ramp)
        if request.posture is not None:
            limits["posture"], one.pull = as_configuration(request.posture, tree, "posture"), _PULL
        self._limits, self._settings = limits, settings
        self._refuse_changes()
        # Goal and report of the current tick. They are not part of the state.
        self._goal_q, self._goal_qd, self._report = np.zeros(n), np.zeros(n), TickReport.records()
        self._names, self._now, self._worst = entry_names(tree), ServoState.unstarted(n), 0.0

    @property
    def q(self) -> Array:
        """Joint positions of the last command [rad or m], shape (n_dof,)."""
        return self._now.joints["q"].copy()

    @property
    def qd(self) -> Array:
        """Joint velocities of the last command [rad/s or m/s], shape (n_dof,)."""
        return self._now.joints["qd"].copy()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Name of the joint of each entry of q."""
        return tuple(self._names)

    @property
    def rate(self) -> float:
        """Ticks per second [Hz]."""
        return float(1.0 / self._settings[0].period)

    @property
    def limits(self) -> Limits:
        """Limits of velocity, acceleration and jerk of each joint, as this servo uses them."""
        of = self._limits
        return Limits(of["speed"].copy(), of["acceleration"].copy(), of["jerk"].copy() if of["jerk"].any() else None)

    @property
    def certified_stop(self) -> tuple[Array, Array]:
        """Positions where the arm would come to rest [rad or m], and bounds of its speeds until then.

        Two arrays of shape (n_dof,).
        """
        joints, settings = self._now.joints, self._settings[0]
        left = joints["qd"] + joints["qdd"] * settings.ramp * settings.period
        return joints["rest_q"].copy(), np.maximum(np.abs(joints["qd"]), np.abs(left))

    @property
    def stop_positions(self) -> Array:
        """Positions of the braking trajectory from now on [rad or m], shape (n, n_dof): those of ``step()`` until rest."""
        joints, counters = copied(self._now.joints), copied(self._now.counters)
        positions = np.empty((max(counters[0].ticks - counters[0].done, 0), self._tree.n_dof))
        entries.write_stop_positions(joints, counters, self._settings, positions)
        return positions

    @property
    def tracking_error(self) -> Array:
        """Largest certified deviation of each joint from its command [rad or m], shape (n_dof,)."""
        return self._limits["tracking_error"].copy()

    @property
    def ticks(self) -> int:
        """Number of ticks since the last ``start``."""
        return self._now.ticks or 0

    @property
    def worst(self) -> float:
        """Longest computing time of a tick since ``start`` [s]; 0 before the first."""
        return self._worst

    def start(self, q: ArrayLike, qd: ArrayLike | None = None, *, lead_out: bool = False) -> Command:
        """Set the state; the acceleration is 0.

        Args:
            q: Joint positions [rad or m], shape (n_dof,).
            qd: Joint velocities [rad/s or m/s], shape (n_dof,); at rest unless given.
            lead_out: Start even if the arm is not certainly free. The next steps then lead it out, as if an object had been
                put into the arm.

        Returns:
            The state as a command.

        Raises:
            InputError: The arm is beyond its limits or cannot stop within them. Or it is not certainly free until it rests, and
                ``lead_out`` is False.
            GeometryError: The robot has no collision shapes, or shapes that cannot be checked.
        """
        lead_out, self._goal_q[:] = as_switch("lead_out", lead_out), as_configuration(q, self._tree, "q")
        self._goal_qd[:] = 0.0 if qd is None else as_configuration(qd, self._tree, "qd")
        if not is_within(self._goal_q, self._tree):
            words = ", ".join(f"{name} by {x:.3g}" for name, x in limit_excess(self._goal_q, self._tree).items())
            back = f": {words}; robot.plan(q, goal, escape=True) begins with the way back within them"
            raise InputError("q", f"beyond the joint limits{degrees_in_words(self._goal_q) or back}")
        if (np.abs(self._goal_qd) > self._limits["speed"]).any():
            raise InputError("qd", "faster than the limits of velocity")
        after, report = self._run(START, _NO_HANDS, 0), self._report[0]
        if report.status == REFUSED and lead_out:
            report.status = NOT_CERTIFIED
        elif report.status == LIMITED_BY_POSITION:
            raise InputError("qd", "the arm cannot stop within its joint limits")
        elif report.status == REFUSED:
            raise InputError(
                "q", "not certainly free, with the clearance, until the arm rests; robot.check_collision says what is near"
            )
        if not are_slow(self._capped, pieces := pieces_of(None, after, self._settings)):
            raise InputError("qd", "a hand is faster than its limit, now or until the arm rests")
        if self._motors is not None and not are_driven(self._motors, pieces):
            torque = self._motors.torques(self._goal_q, self._goal_qd, np.zeros_like(self._goal_qd))
            joint = self._names[int(reach_of(self._motors, None, 0.0).load(torque).argmax())]
            what = f"the torque of {joint}{', or how fast it changes,' if self._motors.limits_rates else ''}"
            raise InputError("q", f"{what} is beyond its limit, now or until the arm rests")
        command = self._command(after)
        self._now, self._worst = after, 0.0
        return command

    def step(
        self,
        *,
        q: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        twist: Goal | None = None,
        pose: Goal | None = None,
        expressed_in: str = "base",
        frame: Frame | None = None,
        measured: ArrayLike | None = None,
    ) -> Command:
        """Compute the next command. Pass at most one goal; without a goal the arm follows its braking trajectory to rest.

        The arm also comes to rest if it was measured farther off its last command than ``tracking_error``, because nothing is
        certified there. The status is then ``off the command``. The arm moves again once it is measured near enough, or after
        ``start`` with the measured position.

        Args:
            q: Joint positions to go to [rad or m], shape (n_dof,).
            velocity: Joint velocities [rad/s or m/s], shape (n_dof,).
            twist: v [m/s] and w [rad/s] of the link, shape (6,); or a dictionary by link, ``{"left_hand": twist}``.
            pose: Goal pose of the link, T_base_link, shape (4, 4); or a dictionary by link. Some hands may have poses and others
                twists. A hand that is not named gets a zero twist; a hand with None moves freely.
            expressed_in: Frame of the twists; see ``Robot.jacobian``.
            frame: Frame of poses, and axes of twists, instead of the base: a link that stands still, such as ``"base"`` of a UR,
                or the frame's pose T_base_frame, shape (4, 4). It requires ``expressed_in="base"``.
            measured: Measured positions of the arm [rad or m], shape (n_dof,); no check unless given.

        Raises:
            InputError: The servo was not started, there are several goals, or a goal has a wrong shape or an entry out of range.
                The state is unchanged: ``step()`` brings the arm to rest.
            UnknownNameError: A goal names a link that the servo does not steer.
        """
        if self._now.ticks is None:
            raise InputError("step", "start(q) comes first")
        began = perf_counter()
        of_hands = twist is not None or pose is not None
        if (q is not None) + (velocity is not None) + of_hands > 1:
            raise InputError("step", "takes one of q, velocity, and twist or pose")
        axes, off = as_frame(expressed_in), -1 if measured is None else self._entry_off(measured)
        if frame is not None and (expressed_in != "base" or not of_hands):
            raise InputError("frame", "goes with poses, and with twists whose expressed_in is 'base'")
        mode, hands = REST, _NO_HANDS
        if of_hands:
            mode, hands = HANDS, self._to_hands(twist, pose, axes, None if frame is None else frame_pose(self._tree, frame))
        elif q is not None:
            mode, self._goal_q[:] = POSITION, as_configuration(q, self._tree, "q")
        elif velocity is not None:
            mode, self._goal_qd[:] = VELOCITY, as_configuration(velocity, self._tree, "velocity")
        after = self._run(mode if off < 0 else REST, hands, self._now.ticks + 1)
        if (self._capped or self._motors is not None) and mode != REST and off < 0:
            after = self._capped_tick(after)
        if off >= 0:
            self._report["status"], self._report["entry"] = OFF_COMMAND, off
        if after.reported:
            after.moving["age"] += self._settings["period"]
        command, worst = self._command(after), max(self._worst, perf_counter() - began)
        self._now, self._worst = after, worst
        return command

    def _capped_tick(self, found: ServoState) -> ServoState:
        """Compute a tick in which hands and motors keep their limits, and report the limit that holds it."""
        after = self._within_caps(found)
        if self._motors is not None and self._report[0].status == LIMITED_BY_ACCELERATION:
            driven = self._drivable(self._motors)
            if driven.share < 1.0:
                self._report["status"], self._report["entry"] = LIMITED_BY_TORQUE, driven.motor
        return after

    def _within_caps(self, found: ServoState) -> ServoState:
        """Return the state that was found, a slower one, or the next state of the braking trajectory."""
        now, settings, q = self._now.joints, self._settings, found.joints["q"]
        if found.counters[0].done > 0:
            return found
        ticks, lead = found.ticks or 0, settings[0].ramp * settings[0].period
        left = found.joints["qd"] + found.joints["qdd"] * lead
        as_found = _motion_of(found)
        slow = share_of(self._capped, q, np.zeros_like(left), left) == 1.0
        pieces = pieces_of(now, found, settings)
        driven = self._motors is None or are_driven(self._motors, pieces)
        if slow and driven and are_slow(self._capped, pieces):
            return found
        stopping, of_stop = self._run(REST, _NO_HANDS, ticks), copied(self._report)
        stop = stopping.joints["qd"] + stopping.joints["qdd"] * lead
        share = share_of(self._capped, q, stop, left)
        most_loaded = None
        if self._motors is not None and not driven:
            reach = reach_of(self._motors, now, settings[0].period)
            of_stopping, of_found = (self._motors.torques(q, *moving) for moving in (_motion_of(stopping), as_found))
            share, most_loaded = min(share, reach.share(of_stopping, of_found)), int(reach.load(of_found).argmax())
        for smaller in (share, 0.5 * share) if share > 0.0 else ():
            self._goal_qd[:] = stop + smaller * (left - stop)
            slower = self._run(VELOCITY, _NO_HANDS, ticks)
            if slower.counters[0].done > 0 or self._keeps_caps(now, slower):
                break
        else:
            slower, self._report = stopping, of_stop
        if self._report[0].status in {FOLLOWING, BRAKING}:
            self._report["status"] = LIMITED_BY_VELOCITY if driven else LIMITED_BY_TORQUE
            if most_loaded is not None:
                self._report["entry"] = most_loaded
        return slower

    def _keeps_caps(self, before: Records[JointState], after: ServoState) -> bool:
        """Whether hands and motors keep their limits in a tick and in the stop after it."""
        pieces = pieces_of(before, after, self._settings)
        return are_slow(self._capped, pieces) and (self._motors is None or are_driven(self._motors, pieces))

    def saved(self) -> ServoState:
        """Return the state, for ``restore``."""
        return self._now

    def restore(self, saved: ServoState) -> None:
        """Go back to a state that ``saved`` returned; ``step()`` continues from there.

        If the world has changed since then, the next step certifies the braking trajectory again.

        Raises:
            InputError: The argument is not a state that ``saved`` of such a servo returned.
        """
        now = self._now
        if not isinstance(saved, ServoState) or len(saved.joints) != len(now.joints):
            raise InputError("saved", f"{type(saved).__name__}; what servo.saved() returned is expected")
        if saved.objects is not now.objects:
            counters = copied(saved.counters)
            counters[0].certified = False
            saved = now._replace(joints=saved.joints, counters=counters, ticks=saved.ticks)
        self._now = saved

    def _entry_off(self, measured: ArrayLike) -> int:
        """Find the entry of q that was measured farthest off the last command, beyond the tracking error; -1 for none."""
        where = as_configuration(measured, self._tree, "measured")
        apart = np.abs(where - self._now.joints["q"]) - self._limits["tracking_error"]
        farthest = int(apart.argmax())
        return farthest if apart[farthest] > ROUNDING else -1

    def __getstate__(self) -> dict[str, Any]:
        """Return the state without the tables of robot and world, which ``__setstate__`` makes again as read-only arrays."""
        of = self._checker
        parts = of.description, of.tree, of.attached, of.user_pairs, of.sampled_pairs
        own = {"_goal_q": self._goal_q.copy(), "_goal_qd": self._goal_qd.copy(), "_report": copied(self._report)}
        return {**self.__dict__, **own, "_now": self._now._replace(objects=None), "_checker": parts, "_driven": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({**state, "_checker": Checker(*state["_checker"])})
        self._refuse_changes()

    def _refuse_changes(self) -> None:
        """Make the constant tables read-only: a tick is compiled for read-only ones."""
        for table in (self._chains, self._limits, self._settings):
            table.setflags(write=False)

    def warm_up(self) -> None:
        """Compile or load all code that a tick needs, for the kinds of shapes in the world now."""
        after = self._run(REST, _NO_HANDS, 0)
        entries.write_stop_positions(after.joints, after.counters, self._settings, np.empty((0, self._tree.n_dof)))

    def _to_hands(self, twist: Goal | None, pose: Goal | None, axes: int, frame: Array | None) -> Records[HandGoal]:
        """Convert the goals of hands, without free hands. frame: T_base_frame, or None for the base."""
        twists, poses = self._by_link(twist, "twist"), self._by_link(pose, "pose")
        hands, is_given = copied(self._hands), []
        hands["frame"] = axes
        for k, link in enumerate(self._links):
            if link in twists and link in poses:
                raise InputError("step", f"{link} is given both a twist and a pose")
            goal = poses.get(link, twists.get(link, _STILL))
            is_given.append(goal is not None)
            if goal is not None and link in poses:
                hands["is_pose"][k] = True
                T = as_one_pose(goal, self._name_of("pose", link))
                hands["pose"][k] = (T if frame is None else frame @ T)[:3].ravel()
            elif goal is not None:
                hands["twist"][k] = twist_in_base(self._tree, _as_twist(goal, self._name_of("twist", link)), frame)
        return hands if all(is_given) else hands[is_given]

    def _by_link(self, goal: Goal | None, name: str) -> Mapping[str, ArrayLike | None]:
        """Return the goals of hands by link. A goal without a name belongs to the only hand."""
        if goal is None:
            return {}
        if isinstance(goal, Mapping):
            for link in goal:
                if link not in self._links:
                    raise UnknownNameError("link", str(link), self._links)
            return goal
        if len(self._links) > 1:
            raise InputError(name, f"is expected by link, since there are several: {', '.join(self._links)}")
        return dict.fromkeys(self._links, goal)

    def _name_of(self, name: str, link: str) -> str:
        """Name of a hand's goal in an error."""
        return name if len(self._links) == 1 else f"{name}[{link!r}]"

    def _run(self, mode: int, hands: Records[HandGoal], ticks: int) -> ServoState:
        """Compute the state after a tick in the current world. The caller makes it the servo's state, by one assignment."""
        scene, objects = self._checker.scene_and_objects(self._world)
        after = self._now.before_tick(objects, ticks)
        if mode == START:
            after.counters[0].next_share = 0
        limits = self._limits if self._motors is None or mode == START else self._drivable(self._motors).limits
        tables = ServoTables(
            self._chains, limits, self._settings, mode, self._goal_q, self._goal_qd, hands,
            after.joints, after.counters, after.wider, after.moving, self._report,
        )  # fmt: skip
        scene.bound(entries.servo_tick)(tables)
        return after

    def _drivable(self, motors: Motors) -> _Drivable:
        """Compute limits with accelerations, of any sign, that the motors can drive together in the current configuration."""
        if self._driven is None or self._driven.of is not self._now:
            limits, joints = self._limits.copy(), self._now.joints
            share, motor = share_of_accelerations(motors, joints, limits["acceleration"], limits["jerk"])
            limits["acceleration"] *= share
            limits["jerk"] *= share if motors.limits_rates else 1.0
            limits.setflags(write=False)
            self._driven = _Drivable(self._now, limits, share, motor)
        return self._driven

    def _command(self, now: ServoState) -> Command:
        joints, (status, share, bounded, entry, body, other, distance) = now.joints, self._report.item()
        joint = self._names[entry] if entry >= 0 else None
        pair = None if body < 0 else (self._name(body, now.objects), self._name(other, now.objects))
        limiting = Limiting(joint, pair, None if pair is None else distance, share, now.too_fast, bounded)
        return Command(joints["q"].copy(), joints["qd"].copy(), joints["qdd"].copy(), STATUS_OF[status], limiting)

    def _name(self, i: int, objects: Objects | None) -> str:
        bodies = self._checker.bodies
        if i < len(bodies.names) or objects is None:
            return bodies.names[i]
        of = objects.layout
        row = rows_of(of.nodes, np.array([i - len(bodies.names)]))[0]
        return of.names[int(of.table[row, OBJECT])]


def _motion_of(state: ServoState) -> tuple[Array, Array]:
    """Velocity and acceleration of a state."""
    return state.joints["qd"], state.joints["qdd"]


def _chains_and_hands(tree: Tree, links: Sequence[str], weights: ArrayLike | None) -> tuple[Array, Records[HandGoal]]:
    """Concatenate the chains of all hands, and fill in the constant fields of each hand's goal."""
    if not links or len(set(links)) < len(links):
        raise InputError("link", f"{links!r}; one link is expected, or several different ones")
    chains = [tree.chain(link) for link in links]
    hands = HandGoal.records(len(links))
    hands["end"] = np.cumsum([len(chain) for chain in chains])
    hands["first"][1:] = hands["end"][:-1]
    given = as_floats("weights", 1.0 if weights is None else weights)
    if given.shape not in {(), (len(links),)} or not ((given >= _MIN_WEIGHT) & (given <= _MAX_WEIGHT)).all():
        expected = f"a number from {_MIN_WEIGHT:g} to {_MAX_WEIGHT:g} for each of the links is expected"
        raise InputError("weights", f"{weights!r}; {expected}")
    hands["weight"] = given
    return np.concatenate(chains), hands


def _accelerations_of(
    tree: Tree, acceleration: ArrayLike | None, jerk: ArrayLike | None, still: NDArray[np.bool_]
) -> tuple[Array, Array | None]:
    """Combine the given limits of acceleration and jerk with those of the description, shape (n_dof,).

    Joints that are ``still`` need no limits.
    """
    own, n = described_limits(tree), tree.n_dof
    most = np.where(still, own.acceleration[~still].max(), own.acceleration)
    if not most.all():
        slow = ", ".join(name for name, one in zip(entry_names(tree), most, strict=True) if not one)
        raise InputError("robot", f"its description allows {slow} an acceleration of 0, so a servo would never move")
    if acceleration is None and np.isinf(most).any():
        few = ", ".join(name for name, one in zip(entry_names(tree), most, strict=True) if np.isinf(one))
        raise InputError("acceleration", f"none is given, and the robot has none of {few}; give acceleration=")
    given = most if acceleration is None else np.minimum(as_limits("acceleration", acceleration, n), most)
    jerks = own.jerk if jerk is None else np.minimum(as_limits("jerk", jerk, n), np.inf if own.jerk is None else own.jerk)
    return WITHIN * given, None if jerks is None else WITHIN * as_limits("jerk", jerks, n)


def _ramp_of(accelerations: Array, jerks: Array | None, tick: float) -> tuple[Array, int, Array]:
    """Lower the accelerations to those reached within ``_MAX_RAMP``; compute the ticks of a ramp and the travel of one tick.

    The travel includes the stop. With limits of jerk it is divided by 8, since the smallest share of a motion is 1/8.
    """
    if jerks is None:
        return accelerations, 0, accelerations * tick * tick
    accelerations = np.minimum(accelerations, jerks * max(_MAX_RAMP, tick))
    ramp = max(1, int(np.ceil((accelerations / jerks).max() / tick - ROUNDING)))
    bend = 2 * ramp * tick
    way = tick * tick / 6 + tick * bend / 2 + bend * bend / 3  # per acceleration at the end of a tick
    return accelerations, ramp, 0.125 * way * np.minimum(jerks * tick, accelerations)


def _as_twist(twist: ArrayLike, name: str) -> Array:
    given = as_floats(name, twist)
    if given.shape != (6,):
        raise InputError(name, f"shape {given.shape}, but shape (6,) is expected: v [m/s], w [rad/s]")
    refuse_out_of_range(given, name)
    return given
