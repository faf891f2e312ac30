"""Computes the window of a moving average that brings the jerk of a motion within limits.

The moving average y(t) of a motion q over the window from t - w to t has the derivatives

    y' = (q(t) - q(t - w)) / w,   y'' = (q'(t) - q'(t - w)) / w,   y''' = (q''(t) - q''(t - w)) / w.

So y satisfies the velocity and acceleration limits of q. Its jerk is at most c(w) / w, where c(w) is the largest change of q''
within a time w. The function c is a growing step function. The smallest w with c(w) <= w times the jerk limit is found by
iterating w = c(w) / limit from below. Source: Biagiotti and Melchiorri, FIR filters for online trajectory planning with
time- and frequency-domain specifications, Control Engineering Practice 20 (2012).

The motion is given by intervals. ``times`` are their borders [s], shape (N + 1,); ``lows`` and ``highs`` bound q'' in each, shape
(N, n_dof). The motion rests for at least w at the borders with the indices ``rest_rows``, which include the first and the last.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt

_MAX_STEPS = 64


@kernel
def least_window(times, lows, highs, jerk_limits, rest_rows, least):
    """The smallest window w >= ``least`` [s] whose moving average is within the jerk limits, shape (n_dof,)."""
    window = least
    for _ in range(_MAX_STEPS):
        wanted = time_of_change(times, lows, highs, jerk_limits, rest_rows, window)
        if wanted <= window:
            return window
        window = wanted * (1.0 + 1e-12)
    return max(window, time_of_change(times, lows, highs, jerk_limits, rest_rows, times[-1] - times[0]))


@kernel
def time_of_change(times, lows, highs, jerk_limits, rest_rows, window):
    """The largest change of q'' within a window, divided by the jerk limit [s]."""
    longest = 0.0
    for section in range(rest_rows.shape[0] - 1):
        first, last = rest_rows[section], rest_rows[section + 1]
        for j in range(jerk_limits.shape[0]):
            change = 0.0
            for i in range(first - 1, last):
                change = max(change, change_from(times, lows, highs, j, (first, last), i, window))
            longest = max(longest, change / jerk_limits[j])
    return longest


@kernel
def change_from(times, lows, highs, j, section, i, window):
    """The largest change of q''_j within a window that begins in interval i of a section.

    section: its first and its last border. For the rest before the section, i is one less than the first border.
    """
    first, last = section
    low = high = 0.0
    if i >= first:
        low, high = lows[i, j], highs[i, j]
    until, k = times[i + 1 if i >= first else first] + window, i + 1
    while k < last and (k == i + 1 or times[k] < until):
        low, high = min(low, lows[k, j]), max(high, highs[k, j])
        k += 1
    if k == last:
        low, high = min(low, 0.0), max(high, 0.0)
    return high - low


@kernel
def bounds_of_acceleration(slope, bend, step, early, late, rate):
    """The minimum and the maximum of q'' = q_s u + q_ss v^2 in an interval.

    In an interval q'' is linear in s. slope: q_s at its start; bend: q_ss; step: ds; early, late: v at its ends; rate: u.
    """
    first, last = slope * rate + bend * early * early, (slope + step * bend) * rate + bend * late * late
    return min(first, last), max(first, last)


@kernel
def write_coasts(steps, x, rest_rows, window, ceilings):
    """Lower the ceilings of x = (ds/dt)^2 so that each speed peak becomes a coast of at least ``window`` [s].

    Without a coast between acceleration and braking, q'' changes by twice the acceleration at once; with it, by once at a time.
    steps: the intervals' lengths, shape (N,). x and ceilings: values at the N + 1 borders.
    """
    for section in range(rest_rows.shape[0] - 1):
        first, last = rest_rows[section], rest_rows[section + 1]
        k = first + 1
        while k < last:
            if x[k] > x[k - 1]:
                low, high = k, k
                while high < last and x[high + 1] == x[k]:
                    high += 1
                if high < last and x[high + 1] < x[k]:
                    k = max(k, flatten_peak(steps, x, (first, last), (low, high), window, ceilings))
            k += 1


@kernel
def flatten_peak(steps, x, section, peak, window, ceilings):
    """Lower the ceilings at one peak; return the last lowered border. section, peak: first and last borders."""
    (first, last), (low, high) = section, peak
    level, length = x[low], 0.0
    for k in range(low, high):
        length += steps[k]
    while length < window * sqrt(level) and low > first and high < last:
        left = x[low - 1] >= x[high + 1]
        if left:
            low -= 1
            length += steps[low]
            level = min(level, x[low])
        else:
            length += steps[high]
            high += 1
            level = min(level, x[high])
    if level > 0.0:
        for k in range(low, high + 1):
            ceilings[k] = min(ceilings[k], level)
    return high
