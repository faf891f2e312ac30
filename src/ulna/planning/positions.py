"""Finds the extreme positions of a motion in each entry of q, and checks position limits.

The extremes are exact, also between grid points. On a line or a parabola an entry has at most one extreme, at a known length. A
moving average is a polynomial of degree five in time between two changes of its jerk. Its Bernstein coefficients bound it, and
bisection makes the bound exact (de Casteljau; Farin, Curves and Surfaces for CAGD, 2002).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROUNDING = 1e-12  # [rad or m], relative for positions above 1: rounding of a motion
_MAX_HALVINGS = 60
_EXACT = 1e-15  # relative to q: bounds nearer to a reached value are not bisected


class Farthest(NamedTuple):
    """The minimum and the maximum of each entry of q with their times, shape (2, n_dof) each."""

    q: Array
    """The values [rad or m]."""
    times: Array
    """The times [s]."""

    def joined(self, later: Farthest) -> Farthest:
        """The extremes of two parts of a motion together."""
        signs = np.array([[-1.0], [1.0]])
        return Farthest(*(np.where(signs * later.q > signs * self.q, *pair) for pair in zip(later, self, strict=True)))


class _Farthest(Protocol):
    def farthest(self, since: float) -> Farthest: ...


class Beyond(NamedTuple):
    """The largest violation of a position limit."""

    column: int
    """The entry of q."""
    position: float
    """The position [rad or m]."""
    limit: float
    """The violated limit [rad or m]."""
    time: float
    """The time [s]."""

    @property
    def amount(self) -> float:
        """The distance beyond the limit [rad or m]."""
        return abs(self.position - self.limit)

    def text(self, names: Sequence[str]) -> str:
        """The joint, its position, the limit and the excess, in words."""
        which = "upper" if self.position > self.limit else "lower"
        return f"{names[self.column]} at {self.position:.6g}, {self.amount:.3g} beyond its {which} limit of {self.limit:.6g}"


class PositionLimits(NamedTuple):
    """The position limits of each entry of q [rad or m], shape (n_dof,) each; infinite where there is none."""

    lower: Array
    upper: Array

    def narrowed(self, other: PositionLimits | None) -> PositionLimits:
        """The intersection of two limits."""
        if other is None:
            return self
        return PositionLimits(np.maximum(self.lower, other.lower), np.minimum(self.upper, other.upper))

    def wider(self, other: PositionLimits) -> PositionLimits:
        """The wider of two limits, which hold for two joined motions."""
        return PositionLimits(np.minimum(self.lower, other.lower), np.maximum(self.upper, other.upper))

    def beyond(self, timed: _Farthest, since: float = 0.0) -> Beyond | None:
        """The largest violation of a motion from a time on; None if it is within the limits up to rounding."""
        return self.beyond_of(timed.farthest(since))

    def beyond_of(self, farthest: Farthest) -> Beyond | None:
        """The largest violation of extreme positions; see ``beyond``."""
        excess = np.stack([self.lower - farthest.q[0], farthest.q[1] - self.upper])
        excess = np.where(excess > ROUNDING * np.maximum(1.0, np.abs(farthest.q)), excess, 0.0)
        if not excess.any():
            return None
        end, column = divmod(int(np.argmax(excess)), excess.shape[1])
        limit = (self.lower, self.upper)[end][column]
        return Beyond(column, float(farthest.q[end, column]), float(limit), float(farthest.times[end, column]))


def farthest_of(q: Array, times: Array) -> Farthest:
    """The extremes of positions, shape (n, n_dof), n >= 1, at times, shape (n,) or (n, n_dof)."""
    rows = np.stack([q.argmin(axis=0), q.argmax(axis=0)])
    columns = np.arange(q.shape[1])
    return Farthest(q[rows, columns], times[rows] if times.ndim == 1 else times[rows, columns])


def farthest_between(q: Array, qd: Array, qdd: Array, times: Array) -> Farthest:
    """The extremes of a motion with continuous accelerations that is a polynomial of degree five between two times.

    q, qd, qdd: the states at the times, shape (n, n_dof) each. times: shape (n,).
    """
    steps = np.diff(times)[:, None]
    return farthest_of_curves(bernstein_of((q[:-1], qd[:-1], qdd[:-1]), (q[1:], qd[1:], qdd[1:]), steps), times)


def bernstein_of(first: tuple[Array, Array, Array], last: tuple[Array, Array, Array], steps: Array) -> Array:
    """The Bernstein coefficients of polynomials of degree five between two states, shape (6, n, n_dof).

    first, last: positions, velocities and accelerations at the ends, shape (n, n_dof) each. steps: durations, shape (n, 1).
    """
    (q, qd, qdd), (q_end, qd_end, qdd_end) = first, last
    return np.stack(
        [
            q,
            q + steps * qd / 5,
            q + steps * (2 * qd / 5 + steps * qdd / 20),
            q_end - steps * (2 * qd_end / 5 - steps * qdd_end / 20),
            q_end - steps * qd_end / 5,
            q_end,
        ]
    )


def farthest_of_curves(control: Array, times: Array) -> Farthest:
    """The extremes of successive polynomials, from their Bernstein coefficients, shape (6, n, n_dof).

    times: the ends of the polynomials, shape (n + 1,).
    """
    at_times = farthest_of(np.concatenate([control[0], control[-1][-1:]]), times)
    least, greatest = (
        _greatest(sign * control, sign * at_times.q[end], at_times.times[end], times) for end, sign in ((0, -1), (1, 1))
    )
    return Farthest(np.stack([-least[0], greatest[0]]), np.stack([least[1], greatest[1]]))


def _greatest(control: Array, best: Array, best_times: Array, times: Array) -> tuple[Array, Array]:
    """The maximum of each column of polynomials and its time, shape (n_dof,) each.

    control: the Bernstein coefficients, shape (6, n, n_dof). best: the largest known values, shape (n_dof,).
    """
    best, best_times = best.copy(), best_times.copy()
    near = _EXACT * np.maximum(1.0, np.abs(best))
    rows, columns = np.nonzero(control.max(axis=0) > best + near)
    control, begin, end = control[:, rows, columns], times[:-1][rows], times[1:][rows]
    for _ in range(_MAX_HALVINGS):
        if not len(columns):
            break
        levels = [control]
        while len(levels[-1]) > 1:
            levels.append(0.5 * (levels[-1][:-1] + levels[-1][1:]))
        middle, reached = 0.5 * (begin + end), levels[-1][0]
        for k in np.flatnonzero(reached > best[columns]).tolist():
            if reached[k] > best[columns[k]]:
                best[columns[k]], best_times[columns[k]] = reached[k], middle[k]
        halves = np.stack([level[0] for level in levels]), np.stack([level[-1] for level in levels[::-1]])
        control, columns = np.concatenate(halves, axis=1), np.tile(columns, 2)
        begin, end = np.concatenate([begin, middle]), np.concatenate([middle, end])
        open_ = control.max(axis=0) > best[columns] + near[columns]
        control, columns, begin, end = control[:, open_], columns[open_], begin[open_], end[open_]
    return best, best_times
