"""Defines the interface of limits of a motion beside joints' limits, such as a hand's speed or torques.

Along a path with the speed ds/dt, each limit constrains x = (ds/dt)^2 and u = d2s/dt2, like the limits of joints
(``kernels.planning.time_optimal``). These constraints hold at the ends of the path's intervals. The peaks of a whole motion are
checked too; if a peak exceeds its limit, the motion is computed again with reduced limits.
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
    """The interface of a motion; between two of ``times`` q is a polynomial of degree five at most."""

    @property
    def times(self) -> Any:  # noqa: D102 - an array; a cached property in some classes
        ...

    @property
    def duration(self) -> float:  # noqa: D102
        ...

    def at(self, t: Array) -> Any:  # noqa: D102
        ...


class Rows(NamedTuple):
    """Further constraints of ``PathIntervals``: lows <= slope u + bend x <= highs, shape (n, m) each."""

    slopes: Array
    """The slopes at the start of each interval."""
    ends: Array
    """The slopes at the end of each interval."""
    bends: Array
    lows: Array
    highs: Array


class Side(NamedTuple):
    """Slopes and bends of constraints at one end of each interval, shape (n, m) each."""

    slopes: Array
    bends: Array


def rows_of(steps: Array, first: Side, last: Side, limits: tuple[Array, Array]) -> Rows:
    """The constraints at the start and at the end of each interval, as rows of ``PathIntervals``.

    The kernel applies each row at both ends, and adds 2 h bend at the end. The rows compensate this, so that each row states one
    constraint, at the start or at the end, twice. limits: lower and upper limits, shape (n, 2 m) each.
    """
    twice = 2.0 * steps[:, None]
    slopes = np.hstack([first.slopes, last.slopes + twice * last.bends])
    ends = np.hstack([first.slopes - twice * first.bends, last.slopes])
    return Rows(slopes, ends, np.hstack([first.bends, last.bends]), *limits)


class PathBounds(NamedTuple):
    """Bounds of the speed ds/dt and of its derivative along a path of n intervals."""

    before: Array
    """The maximum (ds/dt)^2 at the start of each interval, shape (n,)."""
    behind: Array
    """The maximum (ds/dt)^2 at the end of each interval, shape (n,)."""
    rows: Rows | None = None

    def joined(self, other: PathBounds) -> PathBounds:
        """The bounds that satisfy both."""
        both = [rows for rows in (self.rows, other.rows) if rows is not None]
        rows = both[0] if len(both) == 1 else Rows(*map(np.hstack, zip(*both, strict=True))) if both else None
        return PathBounds(np.minimum(self.before, other.before), np.minimum(self.behind, other.behind), rows)


class Peak(Protocol):
    """The interface of a peak of a limited quantity. ``bool(peak)`` is True if it is within its limit."""

    def __bool__(self) -> bool: ...

    @property
    def factor(self) -> float:
        """The factor, at most 1, by which to slow the motion down to be within the limit."""
        ...


class PathLimit(Protocol):
    """The interface of a limit of motions."""

    def along(self, grid: Grid) -> PathBounds:
        """The bounds of the path speed and acceleration along a path."""
        ...

    def peaks(self, timed: Timed, since: float) -> Sequence[Any]:
        """The ``Peak`` of each quantity in a motion from a time on."""
        ...

    def narrowed(self, peaks: Iterable[Any], share: float) -> Self:
        """A copy with limits reduced by the excess of its peaks, and by the factor ``share``."""
        ...

    def with_less_acceleration(self, share: float) -> Self:
        """A copy with a share of its acceleration limits."""
        ...

    def stopping_distance(self, q: Array, qd: Array) -> float:
        """The approximate braking distance of a motion, in the norm of q."""
        ...

    def equals(self, other: object) -> bool:
        """Whether another limit is equal and for the same robot."""
        ...

    def with_dynamics(self, dynamics: Dynamics | None) -> Self:
        """A copy for the same robot with other attached objects."""
        ...

    def refuse_ends(self, q: Array, velocities: Iterable[Array]) -> None:
        """Raise an error if velocities at the ends of a motion, shape (n_dof,) each, exceed the limit.

        q: the positions at the ends, shape (2, n_dof).
        """
        ...


def along(limits: Iterable[PathLimit], grid: Grid) -> PathBounds:
    """The bounds of the path speed and acceleration from several limits."""
    n = len(grid.steps)
    bounds = PathBounds(np.full(n, NO_LIMIT), np.full(n, NO_LIMIT))
    for limit in limits:
        bounds = bounds.joined(limit.along(grid))
    return bounds


def peaks_of(timed: Timed, limits: Iterable[PathLimit], since: float = 0.0) -> tuple[Any, ...]:
    """The peaks of all limited quantities in a motion from a time on."""
    return tuple(peak for limit in limits for peak in limit.peaks(timed, since))


def within_path_limits(timed: Timed, limits: Iterable[PathLimit], since: float = 0.0) -> bool:
    """Whether a motion is within limits from a time on."""
    return all(peaks_of(timed, limits, since))


def factor_of(peaks: Iterable[Peak]) -> float:
    """The factor, at most 1, by which to slow a motion down to be within the limits of its peaks."""
    return min(1.0, *(peak.factor for peak in peaks))


def common_to(first: Iterable[PathLimit], second: Iterable[PathLimit]) -> tuple[PathLimit, ...]:
    """The limits that two motions have in common."""
    others = tuple(second)
    return tuple(limit for limit in first if any(limit.equals(other) for other in others))


def refuse_ends(limits: Iterable[PathLimit], path: Array, velocities: Iterable[Array]) -> None:
    """Raise an error if velocities at the ends of a path, shape (n, n_dof), exceed limits."""
    both = tuple(velocities)
    for limit in limits:
        limit.refuse_ends(path[[0, -1]], both)
