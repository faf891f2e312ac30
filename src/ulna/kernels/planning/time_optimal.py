"""Finds the fastest motion along a path within limits of velocity and acceleration.

TOPP-RA (Pham and Pham, A new approach to time-optimal path parameterization based on reachability analysis, IEEE T-RO 2018). The
path q(s) is given at grid points s_0 .. s_N; x = (ds/dt)^2 and u = d2s/dt2, which is constant in an interval. Then

    qdd_j = q'_j(s) u + q''_j x(s),    x(s) = x_i + 2 u (s - s_i),

and, q'' being constant in an interval too, qdd_j is linear in s there: within its limit at both ends it is within it between.

1. Backwards from x_N, which is given: the greatest x_i from which an x_{i+1} that is allowed can be reached. 0 is always allowed,
   since the limits are the same both ways, so that these sets are intervals [0, beta_i]: from them x_N or less is reached.
   Whether x_N itself is, if it is not 0, shows in the end.
2. Forwards from x_0, which is given: the greatest u_i that is allowed and leads to at most beta_{i+1}.

For one x the allowed u lie between the greatest of some lines in x and the least of others. Their distance is a concave function
of x that is not negative at 0. Its root is found by Newton's steps from above: exact, after as many steps as it has kinks.

Rows: entry j of q' at the start of interval i is ``slope_rows[i n + j]``, at its end ``end_rows[i n + j]``, q'' is
``bend_rows[i n + j]``. From these ``write_bounds`` computes once what is used several times. A number may be one path, or
eight with the same grid.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, load, logical_not, splat, sqrt, store, where
from ulna.kernels.spatial.elementary import maximum, minimum

_FLAT = 1e-12  # a slope below this does not bound u
_UNBOUNDED = 1e300
_MOST_STEPS = 64


@kernel
def write_bounds(slope_rows, end_rows, bend_rows, step_rows, acceleration_limits, bound_rows):
    """Write how each joint bounds u at the start of each interval and at its end: |u - middle x| <= half, 4 n N rows.

    half is ``_UNBOUNDED`` where a joint does not bound u.
    """
    n = acceleration_limits.shape[0]
    for i in range(step_rows.shape[0]):
        step = load(step_rows, i)
        for j in range(n):
            k = i * n + j
            bend, limit = load(bend_rows, k), acceleration_limits[j]
            write_bound(load(slope_rows, k), bend, limit, bound_rows, 4 * k)
            write_bound(load(end_rows, k) + 2.0 * step * bend, bend, limit, bound_rows, 4 * k + 2)


@kernel
def write_bound(slope, bend, limit, bound_rows, row):
    """Write middle and half of |slope u + bend x| <= limit."""
    flat = abs(slope) < _FLAT
    inverse = 1.0 / where(flat, 1.0, slope)
    store(bound_rows, row, where(flat, 0.0, -bend * inverse))
    store(bound_rows, row + 1, where(flat, _UNBOUNDED, limit * abs(inverse)))


@kernel
def write_controllable(bound_rows, bend_rows, step_rows, acceleration_limits, ceiling_rows, beta_rows):
    """Step 1: write beta, N + 1 rows. ceiling_rows: what the limits of velocity allow x to be, x_N last, N + 1 rows."""
    n_intervals = step_rows.shape[0]
    beta = load(ceiling_rows, n_intervals)
    store(beta_rows, n_intervals, beta)
    for k in range(n_intervals):
        i = n_intervals - 1 - k
        x = minimum(load(ceiling_rows, i), flat_ceiling(bound_rows, bend_rows, acceleration_limits, i))
        beta = greatest_x(bound_rows, step_rows, acceleration_limits.shape[0], i, x, beta)
        store(beta_rows, i, beta)


@kernel
def write_fastest(bound_rows, step_rows, n, beta_rows, x_rows, u_rows):
    """Step 2: write x, N + 1 rows, and u, N rows. The first row of x is where it begins, lowered to what is controllable."""
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
    """The greatest x up to a given one for which some u is allowed."""
    for _ in range(_MOST_STEPS):
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
    """At x, the line that bounds u from below and the one from above: value at 0 and slope of each.

    The bounds at the start of the interval and those at its end are gone through side by side: neither waits for the other.
    """
    share = 1.0 / (2.0 * maximum(load(step_rows, i), 1e-300))
    low, high, slope = 0.0 * x, beta * share, 0.0 * x - share
    starts = low + slope * x, low, slope, high + slope * x, high, slope
    ends = starts
    for k in range(i * n, (i + 1) * n):
        starts = with_bound(starts, load(bound_rows, 4 * k), load(bound_rows, 4 * k + 1), x)
        ends = with_bound(ends, load(bound_rows, 4 * k + 2), load(bound_rows, 4 * k + 3), x)
    later, sooner = ends[0] > starts[0], ends[3] < starts[3]
    return (
        where(later, ends[1], starts[1]), where(later, ends[2], starts[2]),
        where(sooner, ends[4], starts[4]), where(sooner, ends[5], starts[5]),
    )  # fmt: skip


@kernel
def with_bound(lines, middle, half, x):
    """The lines that bound u, each with its value at x, its value at 0 and its slope, with |u - middle x| <= half besides."""
    low_at, low, low_slope, high_at, high, high_slope = lines
    least, most = middle * x - half, middle * x + half
    above, below = least > low_at, most < high_at
    return (
        where(above, least, low_at), where(above, -half, low), where(above, middle, low_slope),
        where(below, most, high_at), where(below, half, high), where(below, middle, high_slope),
    )  # fmt: skip


@kernel
def flat_ceiling(bound_rows, bend_rows, acceleration_limits, i):
    """The greatest x that joints allow whose slope is 0: there the acceleration is q'' x, whatever u is."""
    n = acceleration_limits.shape[0]
    ceiling = splat(1e300, load(bend_rows, i * n))
    for j in range(n):
        bend = load(bend_rows, i * n + j)
        first, second = load(bound_rows, 4 * (i * n + j) + 1), load(bound_rows, 4 * (i * n + j) + 3)
        flat = ((first == _UNBOUNDED) | (second == _UNBOUNDED)) & (abs(bend) > 0.0)
        ceiling = where(flat, minimum(ceiling, acceleration_limits[j] / where(flat, abs(bend), 1.0)), ceiling)
    return ceiling


@kernel
def write_times(step_rows, x_rows, time_rows):
    """Write when each grid point is passed [s], N + 1 rows: 2 ds / (sqrt(x_i) + sqrt(x_{i+1}))."""
    t = splat(0.0, load(x_rows, 0))
    store(time_rows, 0, t)
    for i in range(step_rows.shape[0]):
        speeds = sqrt(load(x_rows, i)) + sqrt(load(x_rows, i + 1))
        standing = logical_not(speeds > 0.0)
        t = t + where(standing, 0.0, 2.0 * load(step_rows, i) / where(standing, 1.0, speeds))
        store(time_rows, i + 1, t)
