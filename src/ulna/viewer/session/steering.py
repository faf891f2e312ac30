"""Steers a view's arm by buttons that are held: a servo moves it, so that it touches nothing, and says what limits it."""

import time

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.errors import GeometryError, InputError
from ulna.robot import Robot
from ulna.servo.command import Command
from ulna.servo.servo import Servo
from ulna.viewer.session.session import Session

NAME = "steering"
RATE = 250  # ticks a second
TURNING = 3.0  # [rad/m]: how fast the hand turns, for each m/s at which it moves
_ACCELERATION = 5.0  # [rad/s^2 or m/s^2] of every joint
_HELD_FOR = 0.3  # [s] after the last message of a button, which sends ten a second: so the arm stops if the page is lost
Array = NDArray[np.float64]


def started(robot: Robot, world: World, link: str, q: Array, jerk: float | None = None) -> tuple[Servo | None, str]:
    """A servo at rest at q, shape (n_dof,), and an empty text; or None, and why the servo cannot start there."""
    try:
        servo = robot.servo(world, link=link, acceleration=_ACCELERATION, jerk=jerk, rate=RATE)
        servo.start(q)
    except (InputError, GeometryError) as error:
        return None, str(error)
    return servo, ""


def _warmed(servo: Servo) -> bool:
    servo.warm_up()
    return True


class Steering:
    """Steers the hand of a session. Hold the session's lock around its methods.

    Attributes:
        jerk: The greatest of each joint [rad/s^3 or m/s^3]; None for no limit.
        on: Whether it steers.
        waiting: Whether its kernels are being compiled.
        speed: Of the hand while a button is held [m/s].
        expressed_in: The axes of the buttons: "base", or "link" for those of the hand.
        command: The last command; None if there was none.
        refusal: Why the arm cannot be steered from where it is; empty if it can.
    """

    def __init__(self, session: Session, jerk: float | None = None) -> None:
        self._session, self.jerk = session, jerk
        self.speed, self.expressed_in = 0.1, "base"
        self.turn(on=False)

    def turn(self, *, on: bool) -> None:
        """Begin to steer, or end it: then the arm stays where it is."""
        until = np.zeros((2, 6))
        self.on, self.waiting, self.refusal = on, False, ""
        self.command: Command | None = None
        self._servo: Servo | None = None
        self._until = until  # when each button counts as released, of negative and of positive directions [s]
        self._seen: tuple | None = None  # the link, q and the objects for which the servo was made, or refused
        self._owed = 0.0  # [s] of ticks

    def hold(self, entry: int, sign: int) -> None:
        """Note that a button is held: of an entry of the twist (v, w), and of a sign, 1 or -1."""
        self._until[max(sign, 0), entry] = time.monotonic() + _HELD_FOR

    @property
    def moving(self) -> bool:
        """Whether another frame would move the arm."""
        return self.on and (bool(self._twist().any()) or (self._servo is not None and bool(self._servo.qd.any())))

    @property
    def sentence(self) -> str:
        """What there is to say; empty if it does not steer."""
        if not self.on:
            return ""
        if self.waiting:
            return "steering waits for the compiler"
        return self.refusal or ("hold a button, or its key" if self.command is None else str(self.command))

    def frame(self, seconds: float) -> bool:
        """Move the arm on by a time [s]. Returns whether there is something else to say."""
        if not self.on:
            return False
        before = self.sentence
        servo = self._ready()
        self._owed = self._owed + seconds if servo is not None and self.moving else 0.0
        twist = self._twist()
        while servo is not None and self._owed >= 1 / RATE:
            command = servo.step(twist=twist, expressed_in=self.expressed_in) if twist.any() else servo.step()
            self.command, self._owed = command, self._owed - 1 / RATE
            self._session.q = command.q
            self._seen = self._now()
        return self.sentence != before

    def _twist(self) -> Array:
        held = self._until > time.monotonic()
        return self.speed * (held[1] * 1.0 - held[0]) * np.repeat((1.0, TURNING), 3)

    def _now(self) -> tuple:
        session = self._session
        return session.link, session.q.tobytes(), session.world.objects()

    def _ready(self) -> Servo | None:
        """The servo: a new one where the arm was moved by other means; warm for the world as it is now."""
        now, session, servo = self._now(), self._session, self._servo
        if now == self._seen:
            return servo
        if servo is None or self._seen is None or (now[:2] != self._seen[:2] and now[:2] != (self._seen[0], servo.q.tobytes())):
            found = session.ask(NAME, started, session.robot, session.world, session.link, session.q, self.jerk)
            self._servo, self.refusal = found or (None, "")
            self.command = None
        else:
            found = session.ask(NAME, _warmed, servo)
        self.waiting = found is None
        if found is None:
            return None
        self._seen = now
        return self._servo
