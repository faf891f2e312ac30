"""Steers an arm by a servo: checks its limits, and computes the command of each period."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.arms.arm import ArmModel
from ulna.arms.commands import PERIOD
from ulna.errors import InputError, count_of
from ulna.planning.motion_limits import limits_of
from ulna.servo.servo import Servo

Array = NDArray[np.float64]
Goal = Callable[[float, Array], Mapping[str, Any] | None]
"""Maps time [s] and measured q, shape (n_dof,), to the arguments of ``Servo.step``, as {"pose": T}; None to come to rest."""


class Steering:
    """A servo at the controller's rate, within the limits of an arm.

    Without ``jerk=`` a tick has a constant acceleration, so its jerk by differences is at most twice the acceleration divided by
    the period. An arm's velocity limit may depend on its position. A tick towards the goal is taken only if the arm can come to
    rest within that limit afterwards; otherwise the servo brakes.

    Attributes:
        ended: Whether it came to rest after the goal's end.
    """

    def __init__(self, servo: Servo, model: ArmModel, goal: Goal) -> None:
        """Refuse a servo whose commands the arm would not accept.

        Raises:
            InputError: ``servo`` is not an ``ulna.Servo``; its joints or its rate differ from the arm's; or it allows higher
                velocities, accelerations or jerks than the arm.
        """
        if not isinstance(servo, Servo):
            raise InputError("servo", f"{type(servo).__name__}; a servo as from robot.servo(acceleration=...) is expected")
        if len(servo.joint_names) != model.n_dof:
            raise InputError(
                "servo", f"it moves {count_of(len(servo.joint_names), 'joint')}, and the {model.name} has {model.n_dof}"
            )
        if abs(servo.rate * PERIOD - 1.0) > 1e-9:
            raise InputError("servo", f"it runs at {servo.rate:g} Hz, and the {model.name} at {1 / PERIOD:g} Hz")
        arm, (velocity, acceleration, jerk) = limits_of(model.limits, servo.joint_names), servo.limits
        most, most_jerk = (np.inf if limit is None else limit for limit in (arm.acceleration, arm.jerk))
        allowed, why = {"velocity": arm.velocity, "acceleration": most, "jerk": most_jerk}, ""
        given = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk}
        if jerk is None:
            del given["jerk"]
            allowed["acceleration"], why = np.minimum(most, 0.5 * PERIOD * most_jerk), " by the jerk limit"
        for name, values in given.items():
            limit = np.broadcast_to(allowed[name], values.shape)
            over = np.flatnonzero(values > limit)
            if len(over):
                j, by_jerk = int(over[0]), why if name == "acceleration" else ""
                raise InputError(
                    "servo", f"its {name} limit of {servo.joint_names[j]} is {values[j]:.4g}; at most "
                    f"{limit[j]:.4g} is allowed{by_jerk}; give robot.servo {'jerk=, or ' if by_jerk else ''}{name}=",
                )  # fmt: skip
        self._servo, self._goal, self._arm, self._model = servo, goal, arm, model
        self._tracked, self._ticks, self._leaving, self.ended = bool(servo.tracking_error.any()), 0, False, False

    def begin(self, q: Array) -> None:
        """Start at rest at q.

        Raises:
            InputError: The servo cannot start there.
        """
        self._servo.start(q)

    def step(self, measured: Array) -> Array:
        """The next command, shape (n_dof,). If the goal raises an error, the driver stops the arm."""
        given = None if self._leaving else self._goal(self._ticks * PERIOD, measured)
        self._leaving = given is None
        where = measured if self._tracked else None
        last, before = self._servo.q, self._servo.saved()
        command = self._servo.step(**(given or {}), measured=where)
        if given and not self._can_stop(last, command.q):
            self._servo.restore(before)
            command = self._servo.step(measured=where)
        self._ticks += 1
        self.ended = self._leaving and not command.qd.any()
        return command.q

    def _can_stop(self, last: Array, q: Array) -> bool:
        """Whether the tick to q and the braking trajectory after it keep the arm's position limits and its velocity limits.

        With a jerk limit a joint may reverse during braking, so each tick is checked in its own direction.
        """
        way = np.vstack([last, q, self._servo.stop_positions])
        if ((way[1:] > self._model.upper) | (way[1:] < self._model.lower)).any():
            return False
        velocities = np.diff(way, axis=0) / PERIOD
        return not (np.abs(velocities) > self._arm.velocity_at(way[1:], velocities)).any()
