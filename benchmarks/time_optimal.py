"""Times paths of seven joints over 100 intervals: ``python -m benchmarks.time_optimal``, beside ``toppra`` if it is installed.

The paths are cubic splines through random configurations. Both get the same grid, velocities and accelerations there. Ulna holds
the limits at both ends of each interval, ``toppra`` as it does by itself, so that the durations differ a little: both are shown.
"""

import time

import numpy as np
from scipy.interpolate import CubicSpline

from ulna.drivers import time_parameterisation

N_JOINTS, INTERVALS, PATHS, REPEATS = 7, 100, 50, 20
VELOCITY, ACCELERATION = 2.0, 5.0


def main() -> None:
    """Time the paths, and print the medians."""
    rng, rows = np.random.default_rng(0), []
    for _ in range(PATHS):
        spline = CubicSpline(np.linspace(0.0, 1.0, 6), rng.uniform(-2.0, 2.0, (6, N_JOINTS)))
        rows.append((*of_ulna(spline), *of_toppra(spline)))
    ours, our_duration, theirs, their_duration = np.array(rows).T
    print(f"ulna    {1e6 * np.median(ours):10.1f} us a path, 95 %: {1e6 * np.percentile(ours, 95):.1f} us")
    if np.isfinite(theirs).any():
        longer = our_duration / their_duration
        print(f"toppra  {1e6 * np.median(theirs):10.1f} us a path; {np.median(theirs / ours):.0f} times as long")
        print(f"durations, Ulna's over toppra's: {longer.min():.4f} to {longer.max():.4f}, median {np.median(longer):.4f}")
    else:
        print("toppra is not installed")


def of_ulna(spline: CubicSpline) -> tuple[float, float]:
    """The least time of the compiled entry [s], and the duration of the motion [s]."""
    s = np.linspace(0.0, 1.0, INTERVALS + 1)
    steps, slopes = np.diff(s), np.ascontiguousarray(spline(s, 1))
    bends = np.diff(slopes, axis=0) / steps[:, None]
    fastest = ((VELOCITY / np.abs(slopes)).min(axis=1)) ** 2
    fastest = np.append(fastest, 0.0)
    limits, borders = np.full(N_JOINTS, ACCELERATION), np.array([0, INTERVALS])
    x, u, times = np.zeros(INTERVALS + 1), np.zeros(INTERVALS), np.zeros(INTERVALS + 1)
    starts, ends = slopes[:-1].copy(), slopes[1:].copy()
    time_sections = time_parameterisation.time_sections
    seconds = least(lambda: time_sections(starts, ends, bends, steps, limits, fastest, borders, x, u, times))
    return seconds, float(times[-1])


def of_toppra(spline: CubicSpline) -> tuple[float, float]:
    """The same of ``toppra``'s own entry; NaN if it is not installed."""
    try:
        import toppra  # noqa: PLC0415 - it may be absent
    except ImportError:
        return np.nan, np.nan
    toppra.setup_logging("ERROR")
    limits = np.full((N_JOINTS, 2), (-1.0, 1.0))
    constraints = [
        toppra.constraint.JointVelocityConstraint(VELOCITY * limits),
        toppra.constraint.JointAccelerationConstraint(ACCELERATION * limits),
    ]
    path = toppra.SplineInterpolator(spline.x, spline(spline.x))
    grid = np.linspace(0.0, 1.0, INTERVALS + 1)
    problem = toppra.algorithm.TOPPRA(constraints, path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    seconds = least(lambda: problem.compute_parameterization(0.0, 0.0), repeats=3)
    speeds = problem.compute_parameterization(0.0, 0.0)[1]
    return seconds, float((2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])).sum())


def least(function, repeats: int = REPEATS) -> float:
    """The least time of a call [s]."""
    times = []
    for _ in range(repeats):
        began = time.thread_time()
        function()
        times.append(time.thread_time() - began)
    return min(times)


if __name__ == "__main__":
    main()
