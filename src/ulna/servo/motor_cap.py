"""Checks torques and their rates against the limits of motors, in a tick of a servo and its stop.

A tick and its braking trajectory consist of pieces with constant jerk (``hand_cap.Pieces``). Torques are checked at samples, with
a margin of each limit. The rate of a torque is the difference of two samples, divided by the time between them.
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
_SAMPLE_TIME = 0.01  # [s], between two samples of a stop
_RATE_MARGIN = 0.02  # share of a rate limit: a rate may exceed its mean between two samples
_MIN_SHARE = 1e-3  # of accelerations: without any acceleration a servo could not brake
_MIN_SAMPLES, _MAX_SAMPLES = 3, 40  # per piece, including its ends
_N_CONFIGURATIONS = 200  # random ones, for the largest inertias
_JERK_SHARE = 0.75  # share of a rate limit for jerks; the rest is for the rate that the motion itself causes
_INSTANT = 1e-4  # [s]: time step of the difference for the rate of torque that the motion itself causes


class Reach(NamedTuple):
    """Range of torques that the motors can reach at the end of a tick [Nm or N], shape (n_dof,) each."""

    low: Array
    high: Array

    def load(self, torque: Array) -> Array:
        """Distance of torques from the middle of the range, 1 at its ends; 0 where nothing limits them."""
        with np.errstate(invalid="ignore"):
            return np.nan_to_num(np.abs(torque - 0.5 * (self.low + self.high)) / (0.5 * (self.high - self.low)), nan=0.0)

    def share(self, first: Array, last: Array) -> float:
        """Largest share of a change of torques, from ``first`` to ``last``, that the motors can reach."""
        with np.errstate(divide="ignore", invalid="ignore"):
            rising, falling = (self.high - first) / (last - first), (first - self.low) / (first - last)
            shares = np.where(last > first, rising, np.where(last < first, falling, 1.0))
        return float(np.clip(shares.min(), 0.0, 1.0))


def reach_of(motors: Motors, now: Records[JointState] | None, period: float) -> Reach:
    """Compute the torques that motors can reach in a tick: within their limits, and near enough to their torques now."""
    most = (1.0 - MARGIN) * motors.most
    if now is None or not motors.limits_rates:
        return Reach(-most, most)
    torque, step = motors.torques(now["q"], now["qd"], now["qdd"]), (1.0 - _RATE_MARGIN) * motors.most_rate * period
    return Reach(np.maximum(-most, torque - step), np.minimum(most, torque + step))


def are_driven(motors: Motors, pieces: Pieces) -> bool:
    """Whether the torques of some pieces and their rates are within the limits."""
    q, qd, qdd, jerk, steps = pieces
    count = int(np.clip(np.ceil(steps.max() / _SAMPLE_TIME), _MIN_SAMPLES, _MAX_SAMPLES))
    t = np.linspace(0.0, 1.0, count)[:, None, None] * steps
    at = q + t * (qd + t * (qdd / 2.0 + t * jerk / 6.0)), qd + t * (qdd + t * jerk / 2.0), qdd + t * jerk
    torques = motors.torques(*at)
    driven = bool((np.abs(torques) <= (1.0 - MARGIN) * motors.most).all())
    if not (driven and motors.limits_rates):
        return driven
    changes = np.abs(np.diff(torques, axis=0)).max(axis=0)
    return bool((changes <= (1.0 - _RATE_MARGIN) * motors.most_rate * steps / (count - 1)).all())


def share_of_accelerations(motors: Motors, now: Records[JointState], accelerations: Array, jerks: Array) -> tuple[float, int]:
    """Share of some accelerations and jerks that the motors can drive, and the entry of q whose motor limits it.

    The bounds are |M| a and |M| j with the mass matrix M, so they hold for all signs: an arm that accelerates can also brake.
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
    """Lower some jerks to those that each motor can drive alone, with the largest inertia at its joint.

    A lower jerk makes accelerations take longer to build up. So torques that several joints or the motion cause are left to the
    check of each tick.
    """
    masses = motors.dynamics.mass_matrix(uniform_positions(tree, _N_CONFIGURATIONS, 0), None)
    most = np.diagonal(masses, axis1=-2, axis2=-1).max(axis=0)
    with np.errstate(divide="ignore"):
        return np.minimum(jerks, _JERK_SHARE * motors.most_rate / most)
