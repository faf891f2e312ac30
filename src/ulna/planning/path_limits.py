"""Limits of a motion beside those of its joints, such as the speed of a hand or the torques of motors.

Along a path passed with ds/dt each sets bounds of x = (ds/dt)^2 and of u = d2s/dt2, as the limits of joints do
(``kernels.planning.time_optimal``). These hold at the ends of the intervals of a path. A whole motion is judged by its peaks, and
made with narrower limits where one of them is beyond its limit.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ulna.dynamics.dynamics import Dynamics
    from ulna.planning.blend import Grid

Array = NDArray[np.float64]
NO_LIMIT = 1e300


class Timed(Protocol):
    """A motion in time, of which q is a polynomial of degree five at most between two of ``times``."""

    @property
    def times(self) -> Any:  # noqa: D102 - an array, which some keep in a cached property
        ...

    @property
    def duration(self) -> float:  # noqa: D102
        ...

    def at(self, t: Array) -> Any:  # noqa: D102
        ...


class Rows(NamedTuple):
    """Further rows of ``PathIntervals``: lows <= slope u + bend x <= highs, shape (n, m) each."""

    slopes: Array
    """At the start of each interval."""
    ends: Array
    """At its end."""
    bends: Array
    lows: Array
    highs: Array


class Side(NamedTuple):
    """Slopes and bends of rows at one end of each interval, shape (n, m) each."""

    slopes: Array
    bends: Array


def rows_of(steps: Array, first: Side, last: Side, limits: tuple[Array, Array]) -> Rows:
    """The rows of what is limited at the start of each interval, and of what is limited at its end: twice as many.

    The kernel adds 2 h bend at the end of an interval. So a row has one condition, at the start or at the end, twice.
    limits: lower and upper ones, shape (n, 2 m) each.
    """
    twice = 2.0 * steps[:, None]
    slopes = np.hstack([first.slopes, last.slopes + twice * last.bends])
    ends = np.hstack([first.slopes - twice * first.bends, last.slopes])
    return Rows(slopes, ends, np.hstack([first.bends, last.bends]), *limits)


class PathBounds(NamedTuple):
    """Bounds of ds/dt and of its derivatives along a path of n intervals."""

    before: Array
    """The greatest (ds/dt)^2 at the start of each interval, shape (n,)."""
    behind: Array
    """The same at its end."""
    rows: Rows | None = None

    def joined(self, other: PathBounds) -> PathBounds:
        """The bounds of both."""
        both = [rows for rows in (self.rows, other.rows) if rows is not None]
        rows = both[0] if len(both) == 1 else Rows(*map(np.hstack, zip(*both, strict=True))) if both else None
        return PathBounds(np.minimum(self.before, other.before), np.minimum(self.behind, other.behind), rows)


class Peak(Protocol):
    """The greatest value of a limited quantity in a motion. ``if peak:`` asks whether it is within its limit."""

    def __bool__(self) -> bool: ...

    @property
    def factor(self) -> float:
        """The share of its speed with which the motion is within the limit, at most 1."""
        ...


class PathLimit(Protocol):
    """A limit of motions."""

    def along(self, grid: Grid) -> PathBounds:
        """The bounds along a path."""
        ...

    def peaks(self, timed: Timed, since: float) -> Sequence[Any]:
        """The greatest of each quantity in a motion from a time on, a ``Peak`` each."""
        ...

    def narrowed(self, peaks: Iterable[Any], share: float) -> Self:
        """It with limits as much narrower as these peaks of it are beyond theirs, and by a share more."""
        ...

    def gentler(self, share: float) -> Self:
        """It with a share of what limits accelerations."""
        ...

    def stopping_distance(self, q: Array, qd: Array) -> float:
        """The distance of q about in which a motion stops."""
        ...

    def same_as(self, other: object) -> bool:
        """Whether it is the same limit of the same robot."""
        ...

    def of(self, dynamics: Dynamics | None) -> Self:
        """The limit of the same robot, which holds something else."""
        ...

    def refuse_ends(self, q: Array, velocities: Iterable[Array]) -> None:
        """Refuse velocities at the start and at the end of a motion, shape (n_dof,) each, with which it is beyond its limit.

        q: there, shape (2, n_dof).
        """
        ...


def along(limits: Iterable[PathLimit], grid: Grid) -> PathBounds:
    """The bounds that limits set along a path."""
    n = len(grid.steps)
    bounds = PathBounds(np.full(n, NO_LIMIT), np.full(n, NO_LIMIT))
    for limit in limits:
        bounds = bounds.joined(limit.along(grid))
    return bounds


def peaks_of(timed: Timed, limits: Iterable[PathLimit], since: float = 0.0) -> tuple[Any, ...]:
    """The greatest of each limited quantity in a motion from a time on.

    ``times`` of the motion are the ends of polynomials of degree five.
    """
    return tuple(peak for limit in limits for peak in limit.peaks(timed, since))


def are_kept(timed: Timed, limits: Iterable[PathLimit], since: float = 0.0) -> bool:
    """Whether a motion keeps limits from a time on."""
    return all(peaks_of(timed, limits, since))


def factor_of(peaks: Iterable[Peak]) -> float:
    """The share of its speed with which the peaks of a motion are within their limits, at most 1."""
    return min(1.0, *(peak.factor for peak in peaks))


def common_to(first: Iterable[PathLimit], second: Iterable[PathLimit]) -> tuple[PathLimit, ...]:
    """The limits that two motions both keep."""
    others = tuple(second)
    return tuple(limit for limit in first if any(limit.same_as(other) for other in others))


def refuse_ends(limits: Iterable[PathLimit], path: Array, velocities: Iterable[Array]) -> None:
    """Refuse velocities at the ends of a path, shape (n, n_dof), with which a motion is beyond its limits."""
    both = tuple(velocities)
    for limit in limits:
        limit.refuse_ends(path[[0, -1]], both)
