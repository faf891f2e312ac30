"""Computes the time-optimal parameterization of a path within limits of velocity and acceleration.

TOPP-RA (Pham and Pham, A new approach to time-optimal path parameterization based on reachability analysis, IEEE T-RO 2018). The
path q(s) is given at grid points s_0 .. s_N. Let x = (ds/dt)^2, and u = d2s/dt2, which is constant in an interval. Then

    qdd_j = q'_j(s) u + q''_j x(s),    x(s) = x_i + 2 u (s - s_i).

Since q'' is constant in an interval too, qdd_j is linear in s there. So limits that hold at both ends hold in between. Other
quantities of the same form, such as torques, are further rows; their limits may vary along the path.

1. Backward pass from the given x_N: the largest x_i from which an allowed x_{i+1} can be reached. No lower limit is above 0,
   and no upper limit is below 0, so x = 0 is always allowed. The controllable sets are therefore intervals [0, beta_i], from
   which x_N or less is reached. If x_N is not 0, the caller checks whether x_N itself is reached.
2. Forward pass from the given x_0: the largest allowed u_i that leads to at most beta_{i+1}.

For a given x, the allowed u lie between the maximum of some lines in x and the minimum of others. The gap between them is a
concave function of x, which is not negative at 0. Newton steps from above find its root exactly, in at most as many steps as it
has kinks.

Rows: entry j of q' at the start of interval i is ``slope_rows[i n + j]``, at its end ``end_rows[i n + j]``. Its q'' is
``bend_rows[i n + j]``, and its limits are ``low_rows`` and ``high_rows``. ``write_bounds`` precomputes common terms. A number may
stand for one path, or for eight paths with the same grid.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, load, logical_not, splat, sqrt, store, where
from ulna.kernels.spatial.elementary import maximum, minimum

_FLAT = 1e-12  # a slope below this does not bound u
_UNBOUNDED = 1e300
_MAX_STEPS = 64


@kernel
def write_bounds(intervals, bound_rows):
    """Write the bounds of u from each row at both ends of each interval, 6 n N rows.

    Each bound is low <= u - middle x <= high; low and high are -+``_UNBOUNDED`` if a row does not bound u. intervals:
    ``PathIntervals``, with its arrays as rows.
    """
    n = intervals.bends.shape[0] // intervals.steps.shape[0]
    for i in range(intervals.steps.shape[0]):
        step = load(intervals.steps, i)
        for j in range(n):
            k = i * n + j
            bend, low, high = load(intervals.bends, k), load(intervals.lows, k), load(intervals.highs, k)
            write_bound(load(intervals.slopes, k), bend, (low, high), bound_rows, 6 * k)
            write_bound(load(intervals.ends, k) + 2.0 * step * bend, bend, (low, high), bound_rows, 6 * k + 3)


@kernel
def write_bound(slope, bend, limits, bound_rows, row):
    """Write middle, low and high of the bound limits[0] <= slope u + bend x <= limits[1]."""
    flat = abs(slope) < _FLAT
    inverse = 1.0 / where(flat, 1.0, slope)
    first, last = limits[0] * inverse, limits[1] * inverse
    store(bound_rows, row, where(flat, 0.0, -bend * inverse))
    store(bound_rows, row + 1, where(flat, -_UNBOUNDED, minimum(first, last)))
    store(bound_rows, row + 2, where(flat, _UNBOUNDED, maximum(first, last)))


@kernel
def write_controllable(bound_rows, intervals, ceiling_rows, beta_rows):
    """Perform step 1: write beta, N + 1 rows.

    ceiling_rows: the maximum x within velocity limits, x_N last, N + 1 rows.
    """
    step_rows = intervals.steps
    n = intervals.bends.shape[0] // step_rows.shape[0]
    n_intervals = step_rows.shape[0]
    beta = load(ceiling_rows, n_intervals)
    store(beta_rows, n_intervals, beta)
    for k in range(n_intervals):
        i = n_intervals - 1 - k
        x = minimum(load(ceiling_rows, i), flat_ceiling(bound_rows, intervals, n, i))
        beta = greatest_x(bound_rows, step_rows, n, i, x, beta)
        store(beta_rows, i, beta)


@kernel
def write_fastest(bound_rows, step_rows, n, beta_rows, x_rows, u_rows):
    """Perform step 2: write x, N + 1 rows, and u, N rows.

    The first row of x is given, and lowered to beta_0 if it is larger.
    """
    x = minimum(load(x_rows, 0), load(beta_rows, 0))
    store(x_rows, 0, x)
    for i in range(step_rows.shape[0]):
        beta, step = load(beta_rows, i + 1), load(step_rows, i)
        _, _, value, slope = lines_at(bound_rows, step_rows, n, i, x, beta)
        u = value + slope * x
        following = minimum(maximum(x + 2.0 * step * u, 0.0), beta)
        u = where(step > 0.0, (following - x) / (2.0 * where(step > 0.0, step, 1.0)), 0.0)
        store(u_rows, i, u)
        x = following
        store(x_rows, i + 1, x)


@kernel
def greatest_x(bound_rows, step_rows, n, i, x, beta):
    """The largest x, up to a given one, for which some u is allowed."""
    for _ in range(_MAX_STEPS):
        low, low_slope, high, high_slope = lines_at(bound_rows, step_rows, n, i, x, beta)
        gap = (high + high_slope * x) - (low + low_slope * x)
        closing = low_slope - high_slope
        beyond = (gap < 0.0) & (closing > 0.0)
        if not any_lane(beyond):
            return x
        root = maximum((high - low) / where(beyond, closing, 1.0), 0.0)
        nearer = where(beyond, minimum(root, x), x)
        if not any_lane(nearer < x):
            return nearer
        x = nearer
    return x


@kernel
def lines_at(bound_rows, step_rows, n, i, x, beta):
    """The lines that bound u from below and from above at x: value at 0 and slope of each.

    The bounds at the start and at the end of the interval are processed side by side, for instruction-level parallelism.
    """
    share = 1.0 / (2.0 * maximum(load(step_rows, i), 1e-300))
    low, high, slope = 0.0 * x, beta * share, 0.0 * x - share
    starts = low + slope * x, low, slope, high + slope * x, high, slope
    ends = starts
    for k in range(i * n, (i + 1) * n):
        starts = tighten_lines(starts, bound_rows, 6 * k, x)
        ends = tighten_lines(ends, bound_rows, 6 * k + 3, x)
    later, sooner = ends[0] > starts[0], ends[3] < starts[3]
    return (
        where(later, ends[1], starts[1]), where(later, ends[2], starts[2]),
        where(sooner, ends[4], starts[4]), where(sooner, ends[5], starts[5]),
    )  # fmt: skip


@kernel
def tighten_lines(lines, bound_rows, row, x):
    """Tighten the lines that bound u by a bound from ``write_bound``.

    lines: for the lower and the upper line the value at x, the value at 0 and the slope.
    """
    low_at, low, low_slope, high_at, high, high_slope = lines
    middle, lower, upper = load(bound_rows, row), load(bound_rows, row + 1), load(bound_rows, row + 2)
    least, most = middle * x + lower, middle * x + upper
    above, below = least > low_at, most < high_at
    return (
        where(above, least, low_at), where(above, lower, low), where(above, middle, low_slope),
        where(below, most, high_at), where(below, upper, high), where(below, middle, high_slope),
    )  # fmt: skip


@kernel
def flat_ceiling(bound_rows, intervals, n, i):
    """The largest x allowed by rows with slope 0, whose acceleration q'' x does not depend on u."""
    ceiling = splat(1e300, load(intervals.bends, i * n))
    for j in range(i * n, (i + 1) * n):
        bend = load(intervals.bends, j)
        first, second = load(bound_rows, 6 * j + 2), load(bound_rows, 6 * j + 5)
        flat = ((first == _UNBOUNDED) | (second == _UNBOUNDED)) & (abs(bend) > 0.0)
        limit = where(bend > 0.0, load(intervals.highs, j), -load(intervals.lows, j))
        ceiling = where(flat, minimum(ceiling, limit / where(flat, abs(bend), 1.0)), ceiling)
    return ceiling


@kernel
def write_times(step_rows, x_rows, time_rows):
    """Write the times of the grid points [s], N + 1 rows: sums of 2 ds / (sqrt(x_i) + sqrt(x_{i+1}))."""
    t = splat(0.0, load(x_rows, 0))
    store(time_rows, 0, t)
    for i in range(step_rows.shape[0]):
        speeds = sqrt(load(x_rows, i)) + sqrt(load(x_rows, i + 1))
        standing = logical_not(speeds > 0.0)
        t = t + where(standing, 0.0, 2.0 * load(step_rows, i) / where(standing, 1.0, speeds))
        store(time_rows, i + 1, t)
