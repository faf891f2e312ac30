"""The commands of a servo's full stop, all at once: the formulas of ``kernels.servo.braking`` and ``ramped_stop`` over arrays."""

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.servo import servo_layout as layout

Array = NDArray[np.float64]


def stop_positions(state: Array, settings: Array, n: int, done: int) -> Array:
    """The positions after each tick that is left of a stop of n ticks, of which some are done, shape (n - done, n_dof).

    state, settings: as of ``servo_layout``.
    """
    begin, end, rate, onset = state[[layout.FROM, layout.TO, layout.RATE, layout.ONSET]]
    k = np.arange(done + 1.0, n + 1.0)[:, None]
    if not len(k):
        return np.empty((0, len(begin)))
    h, m = settings[[layout.TICK, layout.RAMP]]
    if m == 0.0:
        x = k / n
        return np.where(k < n, begin + x * (2.0 - x) * (end - begin), end)
    most = (rate + onset * m * h) / (h * (n - 1.5 * m))  # the deceleration
    t, left = k * h, n - k
    in_bend = begin + t * (rate + t * (3.0 * onset - (onset + most) * k / (2.0 * m)) / 6.0)
    steady = end - most * h * h * (0.5 * (left - m) * left + m * m / 6.0)
    at_last = end - most * h * h * left**3 / (6.0 * m)
    return np.where(k <= 2.0 * m, in_bend, np.where(left >= m, steady, at_last))
