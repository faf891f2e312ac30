"""Interpolates points in time by polynomials, as a ROS controller interpolates the points of a message.

Source: ros2_control, joint_trajectory_controller, ``Trajectory::interpolate_between_points``. The degree is five between points
with accelerations, three between points with velocities, and one otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ulna.planning.positions import Farthest, bernstein_of, farthest_of_curves
from ulna.planning.timing import Moment

Array = NDArray[np.float64]
_DEGREE = 5
_CHOICES = {5: (1, 5, 10, 10, 5, 1), 4: (1, 4, 6, 4, 1), 3: (1, 3, 3, 1), 2: (1, 2, 1)}
_MAX_DEVIATION = 1e-4  # [rad or m]: largest distance of the curve from a chord
_SMOOTH = 1e-6  # jumps below this share of the largest value are rounding of a file
_MAX_CHORDS = 2000  # chords per piece
_MIN_STEP, _MIN_DISTANCE = 1e-6, 1e-5  # [s], [rad or m]: points nearer to the previous point are dropped


@dataclass(frozen=True, eq=False)
class SplineMotion:
    """A motion of n polynomials of degree five in time.

    Attributes:
        times: The start of each polynomial and the end of the last [s], shape (n + 1,), beginning with 0.
        control: The Bernstein coefficients [rad or m], shape (6, n, n_dof).
        limits_jerk: Whether velocities and accelerations are continuous, also at both ends.
    """

    times: Array
    control: Array
    limits_jerk: bool

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return float(self.times[-1])

    @cached_property
    def _derivatives(self) -> tuple[Array, ...]:
        """The Bernstein coefficients of q, qd, qdd and the jerk, in this order."""
        found, steps = [self.control], np.diff(self.times)[:, None]
        for degree in (5, 4, 3):
            found.append(degree / steps * np.diff(found[-1], axis=0))
        return tuple(found)

    @property
    def rests(self) -> Array:
        """The times at rest [s]: the start, each point with velocity 0, and the end."""
        rates = self._derivatives[1]
        still = (rates[-1, :-1] == 0.0).all(axis=1) & (rates[0, 1:] == 0.0).all(axis=1)
        return self.times[np.concatenate([[True], still, [True]])]

    def slowed(self, factor: float) -> SplineMotion:
        """A slower motion: at time t it is where this one is at ``factor`` t."""
        return SplineMotion(self.times / factor, self.control, self.limits_jerk)

    def at(self, t: Array) -> Moment:
        """The moments at times within the motion, shape (...)."""
        i = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        share = np.clip((t - self.times[i]) / np.diff(self.times)[i], 0.0, 1.0)
        return Moment(*(_evaluate(control, i, share) for control in self._derivatives))

    def farthest(self, since: float) -> Farthest:
        """The extreme positions from a time on."""
        now = min(since, self.duration)
        i = int(np.clip(np.searchsorted(self.times, now, side="right") - 1, 0, len(self.times) - 2))
        share, control = (now - self.times[i]) / (self.times[i + 1] - self.times[i]), self.control[:, i:].copy()
        control[:, 0] = _split_after(control[:, 0], float(share))
        return farthest_of_curves(control, np.concatenate([[now], self.times[i + 1 :]]))

    def edges_since(self, t: float) -> tuple[Array, Array]:
        """The motion from a time on as straight edges, shape (n, n_dof), and its distances, (n - 1, n_dof).

        There are at least two points. Between two times h apart the motion lies within a h^2 / 8 of the chord, where a is the
        largest acceleration.
        """
        steps, bends = np.diff(self.times), np.abs(self._derivatives[2]).max(axis=0)
        counts = np.ceil(steps * np.sqrt(bends.max(axis=1) / (8.0 * _MAX_DEVIATION)))
        counts = np.clip(counts, 1, _MAX_CHORDS).astype(np.int64)
        of = np.repeat(np.arange(len(steps)), counts)
        number = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
        ends = self.times[of] + (number + 1) / counts[of] * steps[of]
        spreads = bends[of] * ((steps / counts)[of] ** 2 / 8)[:, None] * (1 + 1e-9)
        now = min(t, self.duration)
        later = ends > now
        later[-1] = True
        return self.at(np.concatenate([[now], ends[later]])).q, spreads[later]


def _evaluate(control: Array, i: NDArray[np.int64], share: Array) -> Array:
    """Evaluate the polynomials i at shares of their time, shape (..., n_dof)."""
    degree, share = len(control) - 1, share[..., None]
    weights = (choices * share**k * (1.0 - share) ** (degree - k) for k, choices in enumerate(_CHOICES[degree]))
    return sum((weight * control[k, i] for k, weight in enumerate(weights)), np.zeros((*i.shape, control.shape[2])))


def _split_after(control: Array, share: float) -> Array:
    """The Bernstein coefficients of a polynomial's part after a share of its time, shape (6, n_dof) (de Casteljau)."""
    rows = [control]
    for _ in range(_DEGREE):
        rows.append((1.0 - share) * rows[-1][:-1] + share * rows[-1][1:])
    return np.stack([row[-1] for row in rows[::-1]])


def interpolate_points(times: Array, q: Array, qd: Array, qdd: Array) -> SplineMotion:
    """Interpolate points.

    Args:
        times: Times [s], shape (n,), n >= 2, increasing.
        q: Positions [rad or m], shape (n, n_dof).
        qd: Velocities [rad/s or m/s], shape (n, n_dof); NaN for points without velocities.
        qdd: Accelerations [rad/s^2 or m/s^2], shape (n, n_dof); NaN for points without accelerations.
    """
    kept = _distinct_points(times, q)
    times, q, qd, qdd = times[kept] - times[0], q[kept], qd[kept], qdd[kept]
    steps = np.diff(times)[:, None]
    straight = np.diff(q, axis=0) / steps
    moving = np.asarray(np.isfinite(qd).all(axis=1))
    cubic = (moving[:-1] & moving[1:])[:, None]
    first, last = (np.where(cubic, rates, straight) for rates in (qd[:-1], qd[1:]))
    bending = np.asarray(np.isfinite(qdd).all(axis=1))
    quintic = (bending[:-1] & bending[1:])[:, None] & cubic
    begin = np.where(quintic, qdd[:-1], (6.0 * straight - 4.0 * first - 2.0 * last) / steps)
    end = np.where(quintic, qdd[1:], (2.0 * first + 4.0 * last - 6.0 * straight) / steps)
    at_ends = np.where(np.isfinite(qd[[0, -1]]), qd[[0, -1]], 0.0)
    smooth = _is_continuous(first, last, at_ends) and _is_continuous(begin, end, np.zeros_like(at_ends))
    return SplineMotion(times, bernstein_of((q[:-1], first, begin), (q[1:], last, end), steps), smooth)


def _is_continuous(first: Array, last: Array, at_ends: Array) -> bool:
    """Whether rates at the starts and ends of pieces, shape (n, n_dof), and at the motion's ends are continuous."""
    jumps = np.concatenate([at_ends[:1], last]) - np.concatenate([first, at_ends[1:]])
    return bool(np.abs(jumps).max() <= _SMOOTH * max(np.abs(first).max(), np.abs(last).max()))


def _distinct_points(times: Array, q: Array) -> list[int]:
    """The indices of points, without points too near in time and space for meaningful velocities; both ends stay."""
    kept, end = [0], len(times) - 1
    for k in range(1, end + 1):
        if times[k] - times[kept[-1]] >= _MIN_STEP or np.abs(q[k] - q[kept[-1]]).max() >= _MIN_DISTANCE:
            kept.append(k)
    return kept if kept[-1] == end else [*(kept[:-1] or [0]), end]
