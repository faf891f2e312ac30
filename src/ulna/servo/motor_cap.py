"""Keeps torques within the limits of motors in a tick of a servo, and in the full stop after it.

A tick and its stop are pieces of time with constant jerks (``hand_cap.Pieces``). Torques are judged at samples of these, with a
share of each limit to spare.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ulna.planning.motors import MARGIN, Motors
from ulna.servo.hand_cap import Pieces

Array = NDArray[np.float64]
_APART = 0.01  # [s]: two samples of a stop
_MIN_SHARE = 1e-3  # of accelerations: a servo without any would not brake
_MIN_SAMPLES, _MAX_SAMPLES = 3, 40  # of a piece, with its ends


def are_driven(motors: Motors, pieces: Pieces) -> bool:
    """Whether the torques of some pieces are within the limits."""
    q, qd, qdd, jerk, steps = pieces
    count = int(np.clip(np.ceil(steps.max() / _APART), _MIN_SAMPLES, _MAX_SAMPLES))
    t = np.linspace(0.0, 1.0, count)[:, None, None] * steps
    at = q + t * (qd + t * (qdd / 2.0 + t * jerk / 6.0)), qd + t * (qdd + t * jerk / 2.0), qdd + t * jerk
    return bool((np.abs(motors.torques(*at)) <= (1.0 - MARGIN) * motors.most).all())


def share_of_accelerations(motors: Motors, q: Array, qd: Array, accelerations: Array) -> tuple[float, int]:
    """The share of some accelerations with which torques are within the limits whatever their signs are, and which motor sets it.

    By |M| a, with the mass matrix M. So an arm that turns from speeding up to its stop finds torques for both.
    """
    carried = np.abs(motors.torques(q, qd, np.zeros_like(q)))
    room, most = (1.0 - 2.0 * MARGIN) * motors.most - carried, np.abs(motors.dynamics.mass_matrix(q, None)) @ accelerations
    with np.errstate(divide="ignore"):
        shares = np.where(most > 0.0, np.maximum(room, 0.0) / most, 1.0)
    least = int(shares.argmin())
    return float(np.clip(shares[least], _MIN_SHARE, 1.0)), least


def share_driven(motors: Motors, q: Array, stop: tuple[Array, Array], found: tuple[Array, Array]) -> float:
    """The greatest share of the way from one motion to another, at q, with which torques are within the limits."""
    first, last = (motors.torques(q, *moving) for moving in (stop, found))
    most = (1.0 - MARGIN) * motors.most
    with np.errstate(divide="ignore", invalid="ignore"):
        rising, falling = (most - first) / (last - first), (first + most) / (first - last)
        shares = np.where(last > first, rising, np.where(last < first, falling, 1.0))
    return float(np.clip(shares.min(), 0.0, 1.0))


def most_loaded(motors: Motors, q: Array, found: tuple[Array, Array]) -> int:
    """The entry of q whose torque is the greatest share of its limit."""
    return int(np.argmax(np.abs(motors.torques(q, *found)) / motors.most))
