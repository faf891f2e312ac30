"""Holds the limits of arms, and finds where a sequence of commands exceeds them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError

Array = NDArray[np.float64]
_WITHIN = 1 + 1e-9  # of a limit: rounding of the positions is no excess
_ROUNDING = 4e-15  # [rad], of one position: a third difference has eight of them


class Excess(NamedTuple):
    """The first place at which commands exceed a limit.

    Attributes:
        quantity: ``"position"``, ``"velocity"``, ``"acceleration"`` or ``"jerk"``.
        joint: The entry of q.
        row: Which command.
        value: The quantity there, in rad or m and seconds.
        limit: What is allowed there.
    """

    quantity: str
    joint: int
    row: int
    value: float
    limit: float


@dataclass(frozen=True, eq=False)
class ArmLimits:
    """The limits of an arm's joints, as its controller checks them.

    Attributes:
        name: The arm's name in messages.
        lower: The least positions [rad or m], shape (n_dof,).
        upper: The greatest positions [rad or m], shape (n_dof,).
        velocity: The greatest velocities [rad/s or m/s], shape (n_dof,).
        acceleration: The greatest accelerations [rad/s^2 or m/s^2], shape (n_dof,).
        jerk: The greatest jerks [rad/s^3 or m/s^3], shape (n_dof,).
        braking: None, or for each joint an offset [rad/s] and a deceleration [rad/s^2], shape (n_dof, 2). Then the velocity
            towards a limit of position d away is at most sqrt(2 deceleration d) - offset.

    Raises:
        InputError: The arrays are not of one length, or a limit is not above 0.
    """

    name: str
    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    braking: Array | None = None

    def __post_init__(self) -> None:
        n = as_floats("lower", self.lower).size
        for name in ("lower", "upper", "velocity", "acceleration", "jerk", "braking"):
            if name == "braking" and self.braking is None:
                continue
            array = np.array(as_floats(name, getattr(self, name)))
            shape = (n, 2) if name == "braking" else (n,)
            if array.shape != shape or np.isnan(array).any():
                raise InputError(name, f"shape {array.shape}; numbers of shape {shape} are expected")
            if name not in {"lower", "upper", "braking"} and not (array > 0).all():
                raise InputError(name, "limits above 0 are expected")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_dof(self) -> int:
        """How many joints the arm has."""
        return len(self.lower)

    def velocities_at(self, q: Array) -> tuple[Array, Array]:
        """The least and the greatest velocity at q, shape (..., n_dof) each [rad/s or m/s]."""
        lower, upper, velocity = self.lower, self.upper, self.velocity
        if self.braking is None:
            return np.broadcast_to(-velocity, q.shape), np.broadcast_to(velocity, q.shape)
        offset, deceleration = self.braking.T
        down = np.sqrt(2 * deceleration * np.maximum(q - lower, 0.0)) - offset
        up = np.sqrt(2 * deceleration * np.maximum(upper - q, 0.0)) - offset
        return -np.clip(down, 0.0, velocity), np.clip(up, 0.0, velocity)

    def excess(self, commands: Array, period: float) -> Excess | None:
        """Where commands first exceed a limit by differences of neighbouring ones, or None.

        Args:
            commands: Positions [rad or m], shape (n, n_dof), ``period`` apart; before and after them the arm rests.
            period: The time between two of them [s].
        """
        rest = 3
        q = np.concatenate([np.repeat(commands[:1], rest, axis=0), commands, np.repeat(commands[-1:], rest, axis=0)])
        qd = np.diff(q, axis=0, prepend=q[:1]) / period
        qdd = np.diff(qd, axis=0, prepend=qd[:1]) / period
        jerk = np.diff(qdd, axis=0, prepend=qdd[:1]) / period
        slow, fast = self.velocities_at(q)
        checks = (
            ("position", q, self.lower, self.upper, 1.0),
            ("velocity", qd, slow, fast, 2 / period),
            ("acceleration", qdd, -self.acceleration, self.acceleration, 4 / period**2),
            ("jerk", jerk, -self.jerk, self.jerk, 8 / period**3),
        )
        found = []
        for order, (quantity, values, least, most, rounding) in enumerate(checks):
            slack = np.maximum(np.abs(least), np.abs(most)) * (_WITHIN - 1) + _ROUNDING * rounding
            rows, joints = np.nonzero((values < least - slack) | (values > most + slack))
            if len(rows):
                row, joint = rows[0], joints[0]
                value = float(values[row, joint])
                bound = np.broadcast_to(least if value < 0 else most, values.shape)[row, joint]
                if quantity == "position":
                    bound = (least if value < least[joint] else most)[joint]
                found.append((row, order, Excess(quantity, int(joint), max(0, int(row) - rest), value, float(bound))))
        return min(found, key=lambda one: one[:2])[2] if found else None


# Source: Franka Robotics, "Robot and interface specifications", the limits of the Franka Research 3. Its formula of the velocity near
# a limit of position, as libfranka has it, is about positions some 0.006 rad beyond these: a little more is refused here.
FR3 = ArmLimits(
    "Franka Research 3",
    lower=np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159]),
    upper=np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159]),
    velocity=np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26]),
    acceleration=np.full(7, 10.0),
    jerk=np.full(7, 5000.0),
    braking=np.array([(0.30, 6.0), (0.20, 2.585), (0.20, 3.5), (0.30, 4.0), (0.35, 17.0), (0.35, 5.5), (0.35, 17.0)]),
)
