"""Defines the arguments and results of time parameterization (``time_optimal``)."""

from typing import NamedTuple

from numpy.typing import NDArray


class PathIntervals(NamedTuple):
    """The N intervals of a path q(s), with limits of accelerations and of further rows of the same form."""

    slopes: NDArray
    """The first derivatives q' at the starts, shape (N, n_rows)."""
    ends: NDArray
    """The first derivatives q' at the ends, shape (N, n_rows)."""
    bends: NDArray
    """The second derivatives q'', constant in each interval, shape (N, n_rows)."""
    lows: NDArray
    """The minimum acceleration in each interval, at most 0, shape (N, n_rows)."""
    highs: NDArray
    """The maximum acceleration in each interval, at least 0, shape (N, n_rows)."""
    steps: NDArray
    """The lengths of the intervals, shape (N,)."""


class TimedIntervals(NamedTuple):
    """The N intervals of a path with its time parameterization."""

    times: NDArray
    """The times of the borders [s], shape (N + 1,)."""
    slopes: NDArray
    """The first derivatives q' at the starts, shape (N, n_dof)."""
    bends: NDArray
    """The second derivatives q'', constant in each interval, shape (N, n_dof)."""
    steps: NDArray
    """The lengths of the intervals, shape (N,)."""
    speeds: NDArray
    """The path speed ds/dt at the starts, shape (N,)."""
    rates: NDArray
    """The path acceleration d2s/dt2 in each interval, shape (N,)."""


class Timing(NamedTuple):
    """The time parameterization of a path."""

    x: NDArray
    """(ds/dt)^2 at the grid points, shape (N + 1,); the first value is given."""
    u: NDArray
    """d2s/dt2 in each interval, shape (N,)."""
    times: NDArray
    """The times of the grid points [s], shape (N + 1,)."""
