"""Steers a view's arm with a servo, by buttons that are held.

The servo avoids every contact, and reports the limit or the obstacle that slows the arm.
"""

import time

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.errors import GeometryError, InputError
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of
from ulna.servo.command import Command
from ulna.servo.servo import Servo
from ulna.viewer.session.clearance import ShapeNames
from ulna.viewer.session.first_configuration import free_configuration_near
from ulna.viewer.session.session import Session

NAME, JOINTS = "steering", "joints"
RATE = 250  # [1/s] ticks
TURNING = 3.0  # [rad/m] ratio of the angular speed of the hand to its linear speed
_ACCELERATION = 5.0  # [rad/s^2 or m/s^2] of every joint
_TOO_NEAR = 0.012  # [m] slightly more than the clearance that the servo keeps
_WAY_OUT = "move the obstacle or the arm away, or go to a free pose"
_HELD_FOR = 0.3  # [s] a held button sends ten messages a second; without one for this time the arm stops (a lost page)
Array = NDArray[np.float64]


def start_servo(
    robot: Robot, world: World, link: str, q: Array, jerk: float | None = None, names: ShapeNames | None = None
) -> tuple[Servo | None, str]:
    """Start a servo at rest at q, shape (n_dof,).

    Returns:
        The servo and an empty text; or None and the reason why it cannot start there.
    """
    try:
        servo = robot.servo(world, link=link, acceleration=_ACCELERATION, jerk=jerk, rate=RATE)
    except (InputError, GeometryError) as error:
        return None, str(error)
    try:
        servo.start(q)
    except InputError as error:
        return None, _describe_near_pairs(robot, world, q, names or ShapeNames(robot)) or str(error)
    return servo, ""


def _describe_near_pairs(robot: Robot, world: World, q: Array, names: ShapeNames) -> str:
    """A sentence that names the pairs in contact or too close at q; empty if there are none."""
    near = robot.check_collision(q, world, max_distance=_TOO_NEAR).pairs
    touching = [pair for pair in near if pair.signed_distance <= 0.0]
    what = names.list_pairs(touching or near)
    return what and (f"{what} touch" if touching else f"{what} are too close to each other") + f": {_WAY_OUT}"


def _warm_up(servo: Servo) -> bool:
    servo.warm_up()
    return True


class Steering:
    """Steers the hand of a session. Hold the session's lock around its methods.

    Attributes:
        jerk: The jerk limit of each joint [rad/s^3 or m/s^3]; None for no limit.
        on: Whether it steers.
        waiting: Whether its kernels are being compiled.
        speed: The speed of the hand while a button is held [m/s].
        expressed_in: ``"base"`` or ``"link"``: the buttons move the hand along the axes of the base, or along its own.
            ``"joints"``: they move single joints.
        axes_of: A fixed link whose axes replace those of the base; None for the base.
        command: The last command; None if there was none.
        refusal: Why the arm cannot be steered from its present configuration; empty if it can.
    """

    def __init__(self, session: Session, jerk: float | None = None) -> None:
        self._session, self.jerk = session, jerk
        self.speed, self.expressed_in = 0.1, "base"
        self.axes_of: str | None = None
        self.turn(on=False)

    def turn(self, *, on: bool) -> None:
        """Begin or end steering. The arm stays where it is at the end."""
        until = np.zeros((2, max(6, self._session.robot.n_dof)))
        self.on, self.waiting, self.refusal = on, False, ""
        self.command: Command | None = None
        self._servo: Servo | None = None
        self._step = (0, 0, 0)  # the entry of the present step, its sign, and the number of ticks left
        self._release_times = until  # [s] when each button counts as released; row 0: negative directions, row 1: positive
        self._servo_state: tuple | None = None  # the link, q and the objects for which the servo was made, or refused
        self._pending_time = 0.0  # [s] time for which no ticks were made yet

    def hold(self, entry: int, sign: int) -> None:
        """Note that a button is held. entry: of the twist (v, w), or of q; sign: 1 or -1."""
        self._release_times[max(sign, 0), entry] = time.monotonic() + _HELD_FOR

    def step(self, entry: int, sign: int, size: float) -> None:
        """Move along an entry of the twist, or of q, by a size [m or rad].

        The step is commanded for size / speed. The braking distance makes up for the distance lost while accelerating.
        """
        self._step = entry, sign, round(size / self._speeds()[entry] * RATE)

    def go_free(self) -> None:
        """Put the arm at a nearby collision-free configuration from which it can be steered."""
        session, link = self._session, self._session.link
        robot, world = session.robot, session.world.snapshot()

        def can_start(q: Array) -> bool:
            return start_servo(robot, world, link, q, self.jerk)[0] is not None

        q = free_configuration_near(robot, world, session.q, can_start)
        if q is None:
            self.refusal = "no collision-free pose was found nearby: move the obstacle away"
        else:
            session.q = q

    @property
    def can_move(self) -> bool:
        """Whether a button would move the arm."""
        return self.on and not self.waiting and not self.refusal

    @property
    def moving(self) -> bool:
        """Whether another frame would move the arm."""
        return self.on and (bool(self._directions().any()) or (self._servo is not None and bool(self._servo.qd.any())))

    @property
    def sentence(self) -> str:
        """The status as the page shows it; empty if it does not steer."""
        if not self.on:
            return ""
        if self.waiting:
            return "waiting for the servo to compile"
        return self.refusal or ("hold a button or its key" if self.command is None else str(self.command))

    def frame(self, seconds: float) -> bool:
        """Advance the arm by a time [s]. Returns whether ``sentence`` has changed."""
        if not self.on:
            return False
        before = self.sentence
        servo = self._ready_servo()
        self._pending_time = self._pending_time + seconds if servo is not None and self.moving else 0.0
        speeds = self._speeds()
        while servo is not None and self._pending_time >= 1 / RATE:
            goal = self._directions() * speeds
            if not goal.any():
                command = servo.step()
            elif self.expressed_in == JOINTS:
                command = servo.step(velocity=goal)
            else:
                command = servo.step(twist=goal, expressed_in=self.expressed_in, frame=self.axes_of)
            entry, sign, ticks = self._step
            self._step = entry, sign, max(ticks - 1, 0)
            self.command, self._pending_time = command, self._pending_time - 1 / RATE
            self._session.q = command.q
            self._servo_state = self._state()
        return self.sentence != before

    def _directions(self) -> Array:
        """The direction of each entry: 1, -1, or 0 if it is not to move.

        The entries are those of the twist, shape (6,), or of q, shape (n_dof,).
        """
        held = self._release_times > time.monotonic()
        signs = held[1] * 1.0 - held[0]
        entry, sign, ticks = self._step
        if ticks and self.can_move:
            signs[entry] = sign
        return signs[: self._session.robot.n_dof if self.expressed_in == JOINTS else 6]

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Whether the speed of each entry is in rad/s: of the twist, shape (6,), or of q, shape (n_dof,)."""
        if self.expressed_in != JOINTS:
            return np.repeat((False, True), 3)
        return np.array([coordinate.unit == "rad" for coordinate in coordinates_of(self._session.robot)])

    def _speeds(self) -> Array:
        """The speed of each entry [m/s or rad/s]."""
        return self.speed * np.where(self.turns, TURNING, 1.0)

    def _state(self) -> tuple:
        session = self._session
        return session.link, session.q.tobytes(), (session.robot, session.world.objects())

    def _ready_servo(self) -> Servo | None:
        """The servo, compiled for the present world; None if there is none yet.

        A new servo starts if the arm was moved by other means, or if it is at rest and the obstacles have changed.
        """
        now, session, servo = self._state(), self._session, self._servo
        if now == self._servo_state:
            return servo
        seen = self._servo_state
        moved = servo is None or seen is None or (now[:2] != seen[:2] and now[:2] != (seen[0], servo.q.tobytes()))
        if moved or servo is None or not servo.qd.any():  # at rest, a changed world needs a new servo
            robot, world = session.robot, session.world
            found = session.ask(NAME, start_servo, robot, world, session.link, session.q, self.jerk, session.names)
            self._servo, self.refusal = found or (None, "")
            self.command = None
        else:
            found = session.ask(NAME, _warm_up, servo)
        self.waiting = found is None
        if found is None:
            return None
        self._servo_state = now
        return self._servo
