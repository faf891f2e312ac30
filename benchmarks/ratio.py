"""Compares two timings pass by pass."""

import numpy as np

from ulna.bench.timing import Timing


def ratio(timing: Timing, yardstick: Timing) -> tuple[float, float, float]:
    """Quartiles of timing over yardstick, taken pass by pass, so that common disturbances cancel."""
    lower, median, upper = np.percentile(timing.passes / yardstick.passes, (25, 50, 75))
    return float(lower), float(median), float(upper)
