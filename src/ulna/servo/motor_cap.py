"""Keeps torques, and how fast they change, within the limits of motors in a tick of a servo, and in the full stop after it.

A tick and its stop are pieces of time with constant jerks (``hand_cap.Pieces``). Torques are judged at samples of these, with a
share of each limit to spare. So are the rates of torque: the difference of two samples by the time between them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Records
from ulna.kernels.servo.servo_records import JointState
from ulna.kinematics.sample import uniform_positions
from ulna.kinematics.tree import Tree
from ulna.planning.motors import MARGIN, Motors
from ulna.servo.hand_cap import Pieces

Array = NDArray[np.float64]
_APART = 0.01  # [s]: two samples of a stop
_RATE_MARGIN = 0.02  # of a limit of the rate: what it may be beyond its mean between two samples
_MIN_SHARE = 1e-3  # of accelerations: a servo without any would not brake
_MIN_SAMPLES, _MAX_SAMPLES = 3, 40  # of a piece, with its ends
_PLACES = 200  # random configurations, at which the mass matrix is looked at
_OF_RATE = 0.75  # of a limit of the rate, for jerks: the rest is for what motion adds
_INSTANT = 1e-4  # [s]: in which the rate of torque is looked at that a motion has of itself


class Reach(NamedTuple):
    """The torques that the motors may have at the end of a tick, from ``low`` to ``high`` [Nm or N], shape (n_dof,) each."""

    low: Array
    high: Array

    def load(self, torque: Array) -> Array:
        """Torques as shares of the way from the middle to an end; 0 where nothing limits them."""
        with np.errstate(invalid="ignore"):
            return np.nan_to_num(np.abs(torque - 0.5 * (self.low + self.high)) / (0.5 * (self.high - self.low)), nan=0.0)

    def share(self, first: Array, last: Array) -> float:
        """The greatest share of the way from some torques to others that the motors reach."""
        with np.errstate(divide="ignore", invalid="ignore"):
            rising, falling = (self.high - first) / (last - first), (first - self.low) / (first - last)
            shares = np.where(last > first, rising, np.where(last < first, falling, 1.0))
        return float(np.clip(shares.min(), 0.0, 1.0))


def reach_of(motors: Motors, now: Records[JointState] | None, period: float) -> Reach:
    """What the motors may reach in a tick: of that which they may have, what is near enough to their torques now."""
    most = (1.0 - MARGIN) * motors.most
    if now is None or not motors.limits_rates:
        return Reach(-most, most)
    torque, step = motors.torques(now["q"], now["qd"], now["qdd"]), (1.0 - _RATE_MARGIN) * motors.most_rate * period
    return Reach(np.maximum(-most, torque - step), np.minimum(most, torque + step))


def are_driven(motors: Motors, pieces: Pieces) -> bool:
    """Whether the torques of some pieces, and their rates, are within the limits."""
    q, qd, qdd, jerk, steps = pieces
    count = int(np.clip(np.ceil(steps.max() / _APART), _MIN_SAMPLES, _MAX_SAMPLES))
    t = np.linspace(0.0, 1.0, count)[:, None, None] * steps
    at = q + t * (qd + t * (qdd / 2.0 + t * jerk / 6.0)), qd + t * (qdd + t * jerk / 2.0), qdd + t * jerk
    torques = motors.torques(*at)
    driven = bool((np.abs(torques) <= (1.0 - MARGIN) * motors.most).all())
    if not (driven and motors.limits_rates):
        return driven
    changes = np.abs(np.diff(torques, axis=0)).max(axis=0)
    return bool((changes <= (1.0 - _RATE_MARGIN) * motors.most_rate * steps / (count - 1)).all())


def share_of_accelerations(motors: Motors, now: Records[JointState], accelerations: Array, jerks: Array) -> tuple[float, int]:
    """The share of some accelerations and jerks with which the motors keep their limits, and which motor sets it.

    By |M| a and |M| j, with the mass matrix M, whatever the signs are. So an arm that turns from speeding up to its stop finds
    torques for both.
    """
    q, qd, still = now["q"], now["qd"], np.zeros_like(now["q"])
    masses, carried = np.abs(motors.dynamics.mass_matrix(q, None)), np.abs(motors.torques(q, qd, still))
    room, most = [(1.0 - 2.0 * MARGIN) * motors.most - carried], [masses @ accelerations]
    if motors.limits_rates:
        later = motors.torques(q + _INSTANT * qd, qd + _INSTANT * now["qdd"], now["qdd"])
        drift = np.abs(later - motors.torques(q, qd, now["qdd"])) / _INSTANT
        room.append((1.0 - 2.0 * _RATE_MARGIN) * motors.most_rate - drift)
        most.append(masses @ jerks)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(np.array(most) > 0.0, np.maximum(room, 0.0) / most, 1.0).min(axis=0)
    least = int(shares.argmin())
    return float(np.clip(shares[least], _MIN_SHARE, 1.0)), least


def driven_jerks(motors: Motors, tree: Tree, jerks: Array) -> Array:
    """The jerks that each motor can drive alone, with the largest inertia at its joint, where these are below those given.

    The more a joint's jerk is limited, the longer its accelerations take to begin. What joints do together, and what motion adds,
    is left to each tick.
    """
    masses = motors.dynamics.mass_matrix(uniform_positions(tree, _PLACES, 0), None)
    most = np.diagonal(masses, axis1=-2, axis2=-1).max(axis=0)
    with np.errstate(divide="ignore"):
        return np.minimum(jerks, _OF_RATE * motors.most_rate / most)
