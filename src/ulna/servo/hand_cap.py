"""Keeps hands within their speeds in a tick of a servo, and in the full stop after it, at all times.

A tick and its stop are pieces of time in which each acceleration is linear. The stop that is certified keeps the speeds already.
So a tick is taken only if it and its own stop keep them; else the certified stop goes on, which keeps them too.
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
_WITHIN = 0.995  # of a limit, of the velocity that a tick aims at: the rest is for the bound between samples
_PRECISION = 0.003  # of a limit, of that bound
_MAX_SAMPLES = 40  # of a piece
_QUANTITIES = "speed", "angular_speed"


class Pieces(NamedTuple):
    """Pieces of time with constant jerk: the state at the start of each, shape (k, n_dof), and its duration [s], shape (k, 1)."""

    q: Array
    qd: Array
    qdd: Array
    jerk: Array
    steps: Array


def as_capped(hand: HandLimits | Iterable[HandLimits] | None, tree: Tree) -> tuple[Hand, ...]:
    """The hands whose speeds a servo keeps.

    Raises:
        InputError: One limits an acceleration, or cannot be taken (``planning.hand.as_hands``).
        UnknownNameError: There is no such link.
    """
    hands = as_hands(hand, tree)
    if any(one.limits.acceleration is not None for one in hands):
        raise InputError("hand", "a servo limits the speed and the angular_speed of a hand, and no acceleration of it")
    return hands


def are_slow(hands: Iterable[Hand], pieces: Pieces) -> bool:
    """Whether hands certainly keep their speeds in some pieces."""
    return all(_is_slow(hand, pieces) for hand in hands)


def share_of(hands: Iterable[Hand], q: Array, stop: Array, found: Array) -> float:
    """The greatest share of the way from one velocity to another with which hands, at q, are within their speeds; 0 for none."""
    share = 1.0
    for hand in hands:
        for quantity, *moved in zip(
            _QUANTITIES, hand.moved(q[None], stop[None]), hand.moved(q[None], (found - stop)[None]), strict=True
        ):
            (first,), (way,) = moved
            a, b, c = way @ way, first @ way, first @ first - (_WITHIN * hand.limit(quantity)) ** 2
            if a + 2.0 * b + c > 0.0:
                share = min(share, max((-b + np.sqrt(max(b * b - a * c, 0.0))) / max(a, 1e-300), 0.0) if c < 0.0 else 0.0)
    return share


def pieces_of(before: Records[JointState] | None, after: ServoState, settings: Records[ServoSettings]) -> Pieces:
    """A tick and the stop after it: two pieces, or with a limit of jerk the tick, the bend, the constant deceleration, the end.

    The formulas: ``kernels.servo.braking`` and ``kernels.servo.ramped_stop``.
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
    """Whether a hand certainly keeps its speeds in some pieces: between two samples its velocity is near their chord."""
    q, qd, qdd, jerk, steps = pieces
    bend, end = qd + 0.5 * steps * qdd, qd + steps * (qdd + 0.5 * steps * jerk)  # with qd Bernstein's coefficients
    fastest = np.maximum(np.maximum(np.abs(qd), np.abs(bend)), np.abs(end))
    extents = (np.abs(q) + steps * fastest).max(axis=0)
    rates = hand.rates(extents, fastest, np.maximum(np.abs(qdd), np.abs(qdd + steps * jerk)), np.abs(jerk))
    weights = (rates.arms, hand.limit("speed")), (rates.turns, hand.limit("angular_speed"))
    limited = [(k, rates.third(each), limit) for k, (each, limit) in enumerate(weights) if limit < np.inf]
    apart = max(float((steps[:, 0] ** 2 * bound).max()) / limit for _, bound, limit in limited)
    count = int(min(max(np.ceil(np.sqrt(apart / (8.0 * _PRECISION))), 1), _MAX_SAMPLES))
    t = np.linspace(0.0, 1.0, count + 1)[:, None, None] * steps
    moved = hand.moved(q + t * (qd + t * (qdd / 2.0 + t * jerk / 6.0)), qd + t * (qdd + t * jerk / 2.0))
    for k, bound, limit in limited:
        sizes = np.sqrt((moved[k] * moved[k]).sum(axis=-1).max(axis=0))
        if (sizes + bound * (steps[:, 0] / count) ** 2 / 8.0 > limit).any():
            return False
    return True
