"""Computes time parameterizations of paths, and windows of moving averages."""

import numpy as np

from ulna.engine.decorators import entry
from ulna.engine.signatures import INDICES, MATRIX, NUMBER, NUMBERS, Group
from ulna.kernels.planning import moving_average
from ulna.kernels.planning.time_optimal import write_bounds, write_controllable, write_fastest, write_times
from ulna.kernels.planning.time_records import PathIntervals, TimedIntervals, Timing

_INTERVALS = Group((MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, NUMBERS), PathIntervals)
_TIMED = Group((NUMBERS, MATRIX, MATRIX, NUMBERS, NUMBERS, NUMBERS), TimedIntervals)
_TIMING = Group((NUMBERS, NUMBERS, NUMBERS), Timing)


@entry((_INTERVALS, NUMBERS, INDICES, _TIMING))
def time_sections(intervals, ceilings, borders, timing):
    """Parameterize each section of a path, from x at its first grid point to the ceiling at its last.

    The algorithm is in ``kernels.planning.time_optimal``. intervals: ``PathIntervals``. ceilings: shape (N + 1,), 0 at rests.
    borders: the first grid point of each section, and the last grid point. timing: a ``Timing``.
    """
    x, u, times = timing
    n = intervals.slopes.shape[1]
    beta, bounds = np.empty(x.shape[0]), np.empty(6 * intervals.slopes.size)
    for section in range(borders.shape[0] - 1):
        i, k = borders[section], borders[section + 1]
        size, steps = (k - i) * n, intervals.steps[i:k]
        section_rows = PathIntervals(
            intervals.slopes[i:k].reshape(size),
            intervals.ends[i:k].reshape(size),
            intervals.bends[i:k].reshape(size),
            intervals.lows[i:k].reshape(size),
            intervals.highs[i:k].reshape(size),
            steps,
        )
        write_bounds(section_rows, bounds)
        write_controllable(bounds, section_rows, ceilings[i : k + 1], beta[i : k + 1])
        write_fastest(bounds, steps, n, beta[i : k + 1], x[i : k + 1], u[i:k])
    write_times(intervals.steps, x, times)


@entry((NUMBERS, MATRIX, MATRIX, NUMBERS, INDICES, NUMBERS))
def least_window(times, lows, highs, jerk_limits, rests, window):
    """Raise ``window``, shape (1,), to the shortest one whose moving average is within the jerk limits; always True.

    The algorithm is in ``kernels.planning.moving_average``.
    """
    window[0] = moving_average.least_window(times, lows, highs, jerk_limits, rests, window[0])
    return True


@entry((_TIMED, MATRIX, MATRIX))
def bounds_of_acceleration(intervals, lows, highs):
    """Write the minimum and the maximum acceleration in each of ``TimedIntervals``, shape (N, n_dof); always True."""
    times, slopes, bends, steps, speeds, rates = intervals
    for i in range(steps.shape[0]):
        step, early, rate = steps[i], speeds[i], rates[i]
        late = early + rate * (times[i + 1] - times[i])
        for j in range(slopes.shape[1]):
            slope, bend = slopes[i, j], bends[i, j]
            lows[i, j], highs[i, j] = moving_average.bounds_of_acceleration(slope, bend, step, early, late, rate)
    return True


@entry((NUMBERS, NUMBERS, INDICES, NUMBER, NUMBERS))
def insert_coasts(steps, x, rests, window, ceilings):
    """Lower the speed ceilings so that acceleration and braking have a coast between them; always True."""
    moving_average.write_coasts(steps, x, rests, window, ceilings)
    return True
