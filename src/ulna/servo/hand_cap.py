"""Checks that hands keep their speed limits in a tick of a servo and along its braking trajectory.

The limits hold at all times. A tick and its braking trajectory consist of pieces with constant jerk. A tick is accepted only if
all its pieces keep the limits. Otherwise the arm follows its certified braking trajectory, which keeps them already.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Records
from ulna.errors import InputError
from ulna.kernels.servo.servo_records import JointState, ServoSettings
from ulna.kinematics.tree import Tree
from ulna.planning.hand import Hand, HandLimits, as_hands
from ulna.servo.servo_state import ServoState

Array = NDArray[np.float64]
_AIM = 0.995  # share of a limit that a tick aims at; the rest is a margin for the bound between samples
_PRECISION = 0.003  # precision of the bound between samples, as a share of the limit
_MAX_SAMPLES = 40  # per piece
_QUANTITIES = "speed", "angular_speed"


class Pieces(NamedTuple):
    """Pieces of time with constant jerk: states at their starts, shape (k, n_dof), and durations [s], shape (k, 1)."""

    q: Array
    qd: Array
    qdd: Array
    jerk: Array
    steps: Array


def as_capped(hand: HandLimits | Iterable[HandLimits] | None, tree: Tree) -> tuple[Hand, ...]:
    """Convert the limits of hands that a servo is given.

    Raises:
        InputError: The limits of a hand include an acceleration, or are invalid (``planning.hand.as_hands``).
        UnknownNameError: The robot has no such link.
    """
    hands = as_hands(hand, tree)
    if any(one.limits.acceleration is not None for one in hands):
        raise InputError("hand", "a servo limits the speed and the angular_speed of a hand, and no acceleration of it")
    return hands


def are_slow(hands: Iterable[Hand], pieces: Pieces) -> bool:
    """Whether all hands certainly keep their speed limits in some pieces."""
    return all(_is_slow(hand, pieces) for hand in hands)


def share_of(hands: Iterable[Hand], q: Array, stop: Array, found: Array) -> float:
    """Largest share of the velocity change from ``stop`` to ``found`` with which hands at q keep their limits."""
    share = 1.0
    for hand in hands:
        for quantity, *moved in zip(
            _QUANTITIES, hand.velocities(q[None], stop[None]), hand.velocities(q[None], (found - stop)[None]), strict=True
        ):
            (first,), (way,) = moved
            a, b, c = way @ way, first @ way, first @ first - (_AIM * hand.limit(quantity)) ** 2
            if a + 2.0 * b + c > 0.0:
                share = min(share, max((-b + np.sqrt(max(b * b - a * c, 0.0))) / max(a, 1e-300), 0.0) if c < 0.0 else 0.0)
    return share


def pieces_of(before: Records[JointState] | None, after: ServoState, settings: Records[ServoSettings]) -> Pieces:
    """Split a tick and the braking trajectory after it into pieces of constant jerk.

    Without a limit of jerk they are two: the tick and the stop. With one they are four: the tick, the bend, the constant
    deceleration and the ramp down. The formulas are those of ``kernels.servo.braking`` and ``kernels.servo.ramped_stop``.
    """
    joints, counters, h, m = after.joints, after.counters[0], settings[0].period, settings[0].ramp
    begun: list[tuple[Array, ...]] = []
    q, qd, qdd, n = joints["q"], joints["qd"], joints["qdd"], counters.ticks - counters.done
    none = np.zeros_like(q)
    if before is not None:
        first = before["qdd"] if m > 0.0 else qdd
        begun.append((before["q"], before["qd"], first, (qdd - first) / h, none + h))
    if n > 0 and m == 0.0:
        begun.append((q, qd, -qd / (n * h), none, none + n * h))
    elif n > 0:
        most = (qd + qdd * m * h) / (h * (n - 1.5 * m))
        begun.append((q, qd, qdd, -(most + qdd) / (2.0 * m * h), none + 2.0 * m * h))
        for left, until in ((n - 2.0 * m, m), (m, 0.0)):
            to_go = most * h * h * (0.5 * (left - m) * left + m * m / 6.0)
            jerk = none if until else most / (m * h)
            if left > until:
                begun.append((joints["rest_q"] - to_go, most * h * (left - 0.5 * m), -most, jerk, none + (left - until) * h))
    if not begun:
        begun.append((q, none, none, none, none + h))
    q, qd, qdd, jerk, steps = np.array(begun).swapaxes(0, 1)
    return Pieces(q, qd, qdd, jerk, steps[:, :1])


def _is_slow(hand: Hand, pieces: Pieces) -> bool:
    """Whether a hand certainly keeps its speed limits: by samples, with a bound on the error of their chords."""
    q, qd, qdd, jerk, steps = pieces
    bend, end = qd + 0.5 * steps * qdd, qd + steps * (qdd + 0.5 * steps * jerk)  # with qd, the Bernstein coefficients
    fastest = np.maximum(np.maximum(np.abs(qd), np.abs(bend)), np.abs(end))
    extents = (np.abs(q) + steps * fastest).max(axis=0)
    rates = hand.rates(extents, fastest, np.maximum(np.abs(qdd), np.abs(qdd + steps * jerk)), np.abs(jerk))
    weights = (rates.arms, hand.limit("speed")), (rates.turns, hand.limit("angular_speed"))
    limited = [(k, rates.third_derivative_bound(each), limit) for k, (each, limit) in enumerate(weights) if limit < np.inf]
    apart = max(float((steps[:, 0] ** 2 * bound).max()) / limit for _, bound, limit in limited)
    count = int(min(max(np.ceil(np.sqrt(apart / (8.0 * _PRECISION))), 1), _MAX_SAMPLES))
    t = np.linspace(0.0, 1.0, count + 1)[:, None, None] * steps
    moved = hand.velocities(q + t * (qd + t * (qdd / 2.0 + t * jerk / 6.0)), qd + t * (qdd + t * jerk / 2.0))
    for k, bound, limit in limited:
        sizes = np.sqrt((moved[k] * moved[k]).sum(axis=-1).max(axis=0))
        if (sizes + bound * (steps[:, 0] / count) ** 2 / 8.0 > limit).any():
            return False
    return True
