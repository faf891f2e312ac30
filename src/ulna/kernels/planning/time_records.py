"""Names what the timing of a path is given, and what it writes (``time_optimal``)."""

from typing import NamedTuple

from numpy.typing import NDArray


class PathIntervals(NamedTuple):
    """The intervals of a path q(s), N in all, and what is limited along it: accelerations, and further rows of the same form."""

    slopes: NDArray
    """q' at the start of each, shape (N, n_rows)."""
    ends: NDArray
    """q' at the end of each, shape (N, n_rows)."""
    bends: NDArray
    """q'', which is constant in each, shape (N, n_rows)."""
    lows: NDArray
    """The least acceleration in each, at most 0, shape (N, n_rows)."""
    highs: NDArray
    """The greatest acceleration in each, at least 0, shape (N, n_rows)."""
    steps: NDArray
    """Their lengths, shape (N,)."""


class TimedIntervals(NamedTuple):
    """The intervals of a path that is timed, N in all."""

    times: NDArray
    """Their borders [s], shape (N + 1,)."""
    slopes: NDArray
    """q' at the start of each, shape (N, n_dof)."""
    bends: NDArray
    """q'', which is constant in each, shape (N, n_dof)."""
    steps: NDArray
    """Their lengths, shape (N,)."""
    speeds: NDArray
    """ds/dt at the start of each, shape (N,)."""
    rates: NDArray
    """d2s/dt2 in each, shape (N,)."""


class Timing(NamedTuple):
    """The time parameterization of a path."""

    x: NDArray
    """(ds/dt)^2 at the grid points, of which the first is given, shape (N + 1,)."""
    u: NDArray
    """d2s/dt2 in each interval, shape (N,)."""
    times: NDArray
    """When each grid point is passed [s], shape (N + 1,)."""
