"""Makes jerk-limited motions: moving averages, over a short window, of acceleration-limited base motions.

``kernels.planning.moving_average`` explains why the average stays within the limits, and computes the window w. It passes a path
of lines and parabolas without a stop, in a time longer by w than the base motion.

While the window is within a line, the average is on the line. Elsewhere it leaves the path, and is certified along its own
chords. Between two times h apart, it lies within a h^2 / 8 of the chord, where a is the largest acceleration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.planning.time_records import TimedIntervals
from ulna.planning.blend import (
    CHORDS,
    ON_PATH,
    Certificate,
    Deviation,
    Edges,
    Grid,
    edges_of,
    end_of,
    find_free_cuts,
    is_path_free,
    round_corners,
)
from ulna.planning.entries import time_parameterization
from ulna.planning.path_limits import PathLimit, factor_of, peaks_of
from ulna.planning.positions import Farthest, farthest_between, farthest_of
from ulna.planning.timing import (
    AT_REST,
    Limits,
    Moment,
    Profile,
    Speeds,
    TimedPath,
    follow_lines,
    grid_of,
    time_optimal,
    time_optimal_and_coasting,
)

Array = NDArray[np.float64]
_MIN_WINDOW = 1e-4  # [s]: for a shorter window, differences are rounding
_WITHIN = 1 - 1e-6  # factor of the jerk limits, since jerk is three differences
_MAX_DEVIATION = 2e-5  # [rad or m]: largest distance from a chord, with CHORDS chords per rounding; quadratic in its length
_DEVIATION_SHARE = 0.02  # largest distance from a chord, as a share of the smallest tolerance of constraints
_SHARES = 0.7, 0.5, 0.35, 0.25  # shares of the acceleration that are tried
_SHORT = 0.02  # window as a share of the duration: for a shorter one no slower motion is tried
_MAX_SHARES = 30  # maximum number of reductions of the acceleration
_MAX_EXPECTED = 1e-4  # [rad or m]: largest expected deviation that the corners' certificates include
_FASTER = 1.25  # factor of the speed on a parabola, relative to the length of the edges
MAX_ATTEMPTS = 4  # maximum number of attempts with reduced limits of hands
REDUCTION = 1 - 1e-4  # factor of each reduction beyond the excess
_MAX_TRIES = 12  # iterations of the window, which depends on the path, which depends on the window
_DEVIATION_SHARES = 1.0, 0.15, 0.015  # deviations, as shares of the smallest tolerance, that are tried with less acceleration
_HALVINGS = 4  # maximum halvings of a rounding that is not free; then the motion stops at the corner
_HALVINGS_FIRST = 2  # halvings before less acceleration is tried
_FAR = 0.1  # share of a tolerance: for larger deviations at most corners, smaller roundings do not help
_SLOW = "a tight constraint or a low limit of jerk takes long: give more time, a wider tolerance, or no jerk="


class Span(NamedTuple):
    """An interval of time in which the window overlaps some parabolas."""

    begin: float
    end: float
    first: int
    """The index of the first of these parabolas along the path."""
    last: int
    """The index of the last of these parabolas."""
    acceleration: Array
    """The largest acceleration of the motion in the interval, shape (n_dof,)."""
    deviation: float
    """The largest distance from a chord [rad or m]."""

    def chords(self, begin: float) -> tuple[Array, Array]:
        """The times of the ends of chords, shape (n + 1,), and the motion's distances from them, shape (n, n_dof).

        Between two times h apart the motion lies within a h^2 / 8 of the chord, where a is the largest acceleration.
        """
        step = math.sqrt(8.0 * self.deviation / max(self.acceleration.max(), 1e-300))
        n = max(1, math.ceil((self.end - begin) / step))
        deviation = self.acceleration * ((self.end - begin) / n) ** 2 / 8 * (1 + 1e-9)
        return np.linspace(begin, self.end, n + 1), np.tile(deviation, (n, 1))


@dataclass(frozen=True, eq=False)
class JerkLimited:
    """The moving average of a base motion over the window from t to t + window.

    Attributes:
        base: The base motion. It rests for the window's duration at each stop, and continues straight at its start and its end.
        window: The length of the window [s].
        deviation: The largest distance from a chord for the certificate [rad or m].
    """

    base: TimedPath
    window: float
    deviation: float = _MAX_DEVIATION
    limits_jerk = True

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return float(self.base.times[-1] - self.window)

    @property
    def rests(self) -> Array:
        """The times at rest [s], at which the window is within a rest of the base."""
        return self.base.rests

    def slowed(self, factor: float) -> JerkLimited:
        """A slower motion: at time t it is where this one is at ``factor`` t."""
        return JerkLimited(self.base.slowed(factor), self.window / factor, self.deviation)

    @cached_property
    def times(self) -> Array:
        """The times at which the jerk changes [s]: an end of the window passes a grid point of the base."""
        both = np.concatenate([self.base.times, self.base.times - self.window])
        return np.unique(np.clip(both, 0.0, self.duration))

    @cached_property
    def _areas(self) -> tuple[Array, Array]:
        """The integral of q - q(0) up to each grid point, shape (n + 1, n_dof), and its rounding error."""
        steps = self._integrate(np.arange(len(self.base.grid.steps)), np.diff(self.base.times))[0]
        sums = np.vstack([np.zeros(steps.shape[1]), np.cumsum(steps, axis=0)])
        back = sums[1:] - sums[:-1]
        lost = (sums[:-1] - (sums[1:] - back)) + (steps - back)  # Knuth's sum of two numbers and its error
        return sums, np.vstack([np.zeros(steps.shape[1]), np.cumsum(lost, axis=0)])

    def _integrate(self, i: NDArray[np.int64], t: Array, since: Array | float = 0.0) -> tuple[Array, Array, Array]:
        """The integral of q - q(0), and the changes of q and qd, over a time t of intervals i.

        The shape is (..., n_dof) each. since: the start of t after the interval's start [s]. The polynomials are expanded at
        ``since``: differences of polynomials from the interval's start would lose digits for a short window.
        """
        grid, profile = self.base
        v, a = profile.speeds[i] + profile.accelerations[i] * since, profile.accelerations[i]
        before = ((profile.speeds[i] + 0.5 * a * since) * since)[..., None]
        t, v, a, bends = t[..., None], v[..., None], a[..., None], grid.bends[i]
        way, square = t * t * (v / 2 + a * t / 6), t**3 * (v * v / 3 + v * a * t / 4 + a * a * t * t / 20)
        begin = (grid.starts[i] - grid.starts[0]) + before * (grid.slopes[i] + 0.5 * before * bends)
        slopes, s = grid.slopes[i] + before * bends, (v + 0.5 * a * t) * t
        return (
            begin * t + slopes * way + 0.5 * bends * square,
            s * (slopes + 0.5 * s * bends),
            slopes * (a * t) + bends * s * (v + a * t),
        )

    def at(self, t: Array) -> Moment:
        """The states at times within the motion, shape (...)."""
        (sums, lost), times, (grid, profile) = self._areas, self.base.times, self.base
        until = t + self.window
        i, k = self.base.interval_at(t), self.base.interval_at(until)
        within, last = (i == k)[..., None], np.minimum(i + 1, k)
        speeds, before, behind = profile.speeds[..., None], self.base.at(t), self.base.at(until)
        between = (
            (sums[k] - sums[last]) + (lost[k] - lost[last]),
            grid.starts[k] - grid.starts[last],
            grid.slopes[k] * speeds[k] - grid.slopes[last] * speeds[last],
        )
        parts = (
            self._integrate(i, np.minimum(times[i + 1], until) - t, t - times[i]),
            between,
            self._integrate(k, until - times[k]),
        )
        rates = behind.q - grid.starts[0], behind.qd, behind.qdd
        longer = ((until - t) - self.window)[..., None]  # excess over the window, by rounding
        area, way, faster = (
            first + np.where(within, 0.0, middle + then) - longer * rate
            for first, middle, then, rate in zip(*parts, rates, strict=True)
        )
        q = grid.starts[0] + area / self.window
        if profile.speeds[-1] == 0.0:
            q = np.where((t >= self.duration)[..., None], behind.q, q)
        return Moment(q, way / self.window, faster / self.window, (behind.qdd - before.qdd) / self.window)

    def farthest(self, since: float) -> Farthest:
        """The extreme positions from a time on; between two of ``times`` q is a polynomial of degree five."""
        times = np.concatenate([[since], self.times[self.times > since]])
        q, qd, qdd, _ = self.at(times)
        return farthest_between(q, qd, qdd, times) if len(times) > 1 else farthest_of(q, times)

    def edges_since(self, t: float) -> tuple[Array, Array]:
        """The motion from a time on as straight edges, shape (n, n_dof), and its distances, (n - 1, n_dof).

        There are at least two points. While the window overlaps no parabola, the motion is on a line, which is one edge up to a
        stop.
        """
        now = min(t, self.duration)
        times, spreads = [np.array([now])], []

        def go_straight(until: float) -> None:
            ends = np.unique(np.concatenate([self.rests[(self.rests > now) & (self.rests < until)], [until]]))
            times.append(ends)
            spreads.append(np.zeros((len(ends), self.base.grid.starts.shape[1])))

        for span in self._spans:
            if span.end > now:
                if span.begin > now:
                    go_straight(span.begin)
                ends, deviation = span.chords(max(span.begin, now))
                times.append(ends[1:])
                spreads.append(deviation)
                now = span.end
        if now < self.duration or not spreads:
            go_straight(self.duration)
        return self.at(np.concatenate(times)).q, np.concatenate(spreads)

    @property
    def deviation_bound(self) -> float:
        """An upper bound of the deviation from the base's path in q [rad or m]; 0 on lines."""
        return max((average_deviation(span.acceleration, self.window) for span in self._spans), default=0.0)

    @property
    def reach(self) -> float:
        """The path length around a parabola on which the motion may deviate: half the window at top speed."""
        return 0.5 * self.window * float(self.base.profile.speeds.max())

    def corners_not_free(self, certificate: Certificate) -> list[int]:
        """The indices of the path's parabolas near which the motion is not free."""
        spans, found = [span.chords(span.begin) for span in self._spans], []
        ends = np.cumsum([len(times) for times, _ in spans])
        q = np.split(self.at(np.concatenate([times for times, _ in spans])).q, ends[:-1]) if spans else []
        for span, points, (_, spreads) in zip(self._spans, q, spans, strict=True):
            if not is_path_free(certificate, points, spreads):
                found += range(span.first, span.last + 1)
        return found

    @cached_property
    def _spans(self) -> list[Span]:
        """The intervals in which the window overlaps parabolas, in order."""
        bends, times = self.base.grid.bends, self.base.times
        changes = (bends[1:] != bends[:-1]).any(axis=1)
        first, last = np.flatnonzero(np.concatenate([[True], changes])), np.flatnonzero(np.concatenate([changes, [True]]))
        bent = bends[first].any(axis=1)
        if not bent.any():
            return []
        begin, end = np.maximum(times[first[bent]] - self.window, 0.0), times[last[bent] + 1]
        apart = np.flatnonzero(begin[1:] > end[:-1]) + 1
        groups = np.stack([np.concatenate([[0], apart]), np.concatenate([apart, [len(begin)]]) - 1], axis=1)
        most = np.maximum(*map(np.abs, bounds_of_acceleration(self.base)))
        spans, deviation = [], min(self.deviation, _MAX_DEVIATION * (CHORDS / self.base.grid.chords) ** 2)
        for i, k in groups.tolist():
            start, until = float(begin[i]), min(float(end[k]), self.duration)
            reached = self.base.interval_at(np.array([start, until + self.window])).tolist()
            spans.append(Span(start, until, i, k, most[reached[0] : reached[1] + 1].max(axis=0), deviation))
        return spans


def timed_path(
    path: Array,
    lengths: Array,
    blend: float,
    limits: Limits,
    certificate: Certificate,
    within: float = math.inf,
    speeds: Speeds = AT_REST,
) -> TimedPath | JerkLimited | None:
    """The fastest motion along a path, shape (n, n_dof), n >= 2, with its corners rounded where that is free.

    It is within the limits of hands at all times. In a moving average a hand is slightly faster than in the base. So the motion
    is computed again with reduced limits, and finally slowed down, until its peaks are within the limits.

    Args:
        path: The points of the path.
        lengths: The lengths of its edges, above 0, shape (n - 1,).
        blend: The largest length of an edge that a rounding replaces.
        limits: The limits of joints.
        certificate: The certificate, with the limits of hands and torques.
        within: The largest distance from the path in each entry of q [rad or m]. Parabolas use half of it, the moving average the
            other half.
        speeds: The path speeds at the ends.

    Returns:
        The motion. None if the speeds at its ends are not possible within the limits; from rest to rest a motion always exists.
    """
    narrower, slowest = certificate, None
    for _ in range(MAX_ATTEMPTS):
        timed = _timed_path(path, lengths, blend, limits, narrower, within, speeds)
        if timed is None or not certificate.caps:
            return timed
        peaks = peaks_of(timed, certificate.caps)
        if all(peaks):
            return timed
        narrower = narrower._replace(caps=tuple(cap.narrowed(peaks, REDUCTION) for cap in narrower.caps))
        if speeds == AT_REST:
            slowed = timed.slowed(REDUCTION * factor_of(peaks))
            slowest = slowed if slowest is None or slowed.duration < slowest.duration else slowest
    return slowest


def _timed_path(
    path: Array, lengths: Array, blend: float, limits: Limits, certificate: Certificate, within: float, speeds: Speeds
) -> TimedPath | JerkLimited | None:
    """``timed_path`` without the check of peaks between the grid points of its path."""
    (velocity, acceleration, jerk), edges = limits, edges_of(path, lengths, certificate.chords)
    if jerk is None:
        pieces = round_corners(edges, find_free_cuts(edges, blend, certificate, within))
        return time_optimal(grid_of(pieces), velocity, acceleration, speeds, caps=certificate.caps)
    deviation = _expected_deviation(edges, velocity, acceleration, jerk)
    cuts = find_free_cuts(edges, blend, certificate, 0.5 * within, deviation)
    if np.count_nonzero(cuts) < np.count_nonzero(edges.turns):
        deviation, cuts = ON_PATH, find_free_cuts(edges, blend, certificate, 0.5 * within)
    halvings, most, largest = np.zeros(len(cuts), dtype=int), math.inf, cuts.copy()
    slower = [share * certificate.tolerance for share in _DEVIATION_SHARES if certificate.tolerance < math.inf]
    moves = speeds != AT_REST
    while cuts.any() or moves or certificate.caps:  # seven phases need one speed limit per line, but a hand's varies along it
        near = min(0.5 * within, most)
        certificate.limit.refuse_longer(_SLOW)
        motion = _average_within(round_corners(edges, cuts), velocity, acceleration, jerk, near, speeds, certificate)
        if motion is None and (moves or not cuts.any()):
            return None
        if motion is None:
            cuts[:] = 0.0
            continue
        by = average_deviation(acceleration, motion.window)
        is_covered = not halvings.any() and by <= deviation.by and motion.reach <= deviation.reach
        corners = np.flatnonzero(cuts)[[] if is_covered else motion.corners_not_free(certificate)]
        if not len(corners):
            return motion
        hopeless = motion.deviation_bound > _FAR * certificate.tolerance and len(corners) > 0.5 * np.count_nonzero(cuts)
        if slower and (hopeless or (halvings[corners] == _HALVINGS_FIRST).any()):
            most, cuts, halvings[:] = slower.pop(0), largest.copy(), 0
            continue
        halvings[corners] += 1
        cuts[corners] = np.where(halvings[corners] > _HALVINGS, 0.0, 0.5 * cuts[corners])
    return follow_lines(round_corners(edges, cuts), velocity, acceleration, jerk)


def _expected_deviation(edges: Edges, velocity: Array, acceleration: Array, jerk: Array) -> Deviation:
    """The expected deviation of the moving average from the path, which the corners' certificates include; 0 if it is large.

    The expected window is 2 a / j, since the acceleration may jump from -a to a.
    """
    window = 2.0 * float((acceleration / jerk).max()) * (1 + 1e-5)
    by = average_deviation(acceleration, window)
    if by > _MAX_EXPECTED:
        return ON_PATH
    with np.errstate(divide="ignore"):
        speeds = (velocity / np.abs(edges.directions)).min(axis=1)
    return Deviation(by, 0.5 * window * _FASTER * float(speeds.max()))


def _average_within(
    pieces: Grid, velocity: Array, acceleration: Array, jerk: Array, within: float, speeds: Speeds, certificate: Certificate
) -> JerkLimited | None:
    """The moving average that deviates from the pieces by at most ``within``, with acceleration reduced as needed; or None."""
    share = 1.0
    for _ in range(_MAX_SHARES):
        motion = _fastest_average(pieces, velocity, share * acceleration, jerk, speeds, certificate)
        if motion is None or math.isinf(within) or motion.deviation_bound <= within:
            return motion
        share *= min(0.95, max(0.2, (within / motion.deviation_bound) ** (1 / 3)))  # the window grows with the acceleration
    return None


def _fastest_average(
    pieces: Grid, velocity: Array, acceleration: Array, jerk: Array, speeds: Speeds, certificate: Certificate
) -> JerkLimited | None:
    """The fastest moving average along pieces: of the time-optimal motion, or of one with less acceleration or with coasts.

    Less acceleration needs a shorter window. A motion that switches from acceleration to braking at once needs a window twice as
    long as a motion that coasts in between.
    """
    grid, find, caps = grid_of(pieces), _best_candidate if speeds == AT_REST else _moving_candidate, certificate.caps
    best = find(grid, velocity, acceleration, jerk, speeds, caps)
    for share in _SHARES:
        if best is not None and best.window < _SHORT * best.duration:
            break
        slower = find(grid, velocity, share * acceleration, jerk, speeds, caps)
        if slower is None or (best is not None and slower.duration >= best.duration):
            break
        best = slower
    if best is None:
        return None
    return JerkLimited(add_pauses(best.motion, best.window, speeds.end), best.window, max_deviation(certificate))


def max_deviation(certificate: Certificate) -> float:
    """The largest distance from a certified chord [rad or m], much smaller than the tolerances of constraints."""
    return min(_MAX_DEVIATION, _DEVIATION_SHARE * certificate.tolerance)


class _Candidate(NamedTuple):
    """An acceleration-limited motion, and the window with which its moving average is within the jerk limits."""

    motion: TimedPath
    window: float

    @property
    def duration(self) -> float:
        """The duration of the moving average, with a pause of the window at each stop [s]."""
        return float(self.motion.times[-1]) + self.window * (len(self.motion.grid.borders) - 1)


def _best_candidate(
    grid: Grid,
    velocity: Array,
    acceleration: Array,
    jerk: Array,
    speeds: Speeds,
    caps: tuple[PathLimit, ...],
    least: float = _MIN_WINDOW,
) -> _Candidate | None:
    """The faster of the time-optimal motion and one that coasts; None if the speeds at the ends are not possible."""
    motions = time_optimal_and_coasting(grid, velocity, acceleration, float((acceleration / jerk).max()), speeds, caps)
    candidates = [_Candidate(motion, min_window(motion, jerk, least)) for motion in motions]
    return min(candidates, key=lambda candidate: candidate.duration, default=None)


def _moving_candidate(
    grid: Grid, velocity: Array, acceleration: Array, jerk: Array, speeds: Speeds, caps: tuple[PathLimit, ...]
) -> _Candidate | None:
    """The fastest motion with a velocity at an end, where its base continues straight for half the window.

    So the moving average begins at the path's start. The cut part of the path depends on the window, and the window depends on
    the remaining path; so both are found by iteration.
    """
    window = _MIN_WINDOW
    for _ in range(_MAX_TRIES):
        left = _trim_ends(grid, 0.5 * window * speeds.start, 0.5 * window * speeds.end)
        found = None if left is None else _best_candidate(left, velocity, acceleration, jerk, speeds, caps, window)
        if found is None or found.window <= window:
            return found
        window = found.window * (1 + 1e-9)
    return None


def _trim_ends(grid: Grid, first: float, last: float) -> Grid | None:
    """The path without lengths of its first and last line; None if these lines are too short."""
    ends = np.concatenate([[0.0], np.cumsum(grid.steps)])
    i, k = int(np.searchsorted(ends, first, side="right")) - 1, int(np.searchsorted(ends, ends[-1] - last, side="left"))
    lines = grid.bends[: i + 1].any(), grid.bends[k - 1 :].any(), grid.borders[1] <= i, grid.borders[-2] >= k
    if any(lines) or i >= k - 1:
        return None
    starts, slopes, bends, steps = (each[i:k].copy() for each in grid[:4])
    starts[0] += (first - ends[i]) * slopes[0]
    steps[0] -= first - ends[i]
    steps[-1] -= ends[k] - (ends[-1] - last)
    return Grid(starts, slopes, bends, steps, np.clip(grid.borders - i, 0, k - i), grid.chords)


def min_window(motion: TimedPath, jerk: Array, least: float = _MIN_WINDOW) -> float:
    """The shortest window with which a motion's moving average is within the jerk limits [s], at least ``least``."""
    lows, highs = bounds_of_acceleration(motion)
    window = np.array([least])
    time_parameterization.least_window(motion.times, lows, highs, jerk * _WITHIN, motion.grid.borders, window)
    return float(window[0])


def bounds_of_acceleration(motion: TimedPath) -> tuple[Array, Array]:
    """The minimum and the maximum acceleration in each interval, shape (n, n_dof) each."""
    (_, slopes, bends, steps, *_), (times, speeds, rates, _) = motion
    lows, highs = np.empty_like(slopes), np.empty_like(slopes)
    intervals = TimedIntervals(times, slopes, bends, steps, speeds, rates)
    time_parameterization.bounds_of_acceleration(intervals, lows, highs)
    return lows, highs


def average_deviation(acceleration: Array, window: float) -> float:
    """The largest difference of a moving average from the middle of its window: a w^2 / 24."""
    return float(acceleration.max()) * window**2 / 24


def add_pauses(motion: TimedPath, pause: float, end: float = 0.0) -> TimedPath:
    """The motion with a pause [s] at each stop, and extended straight by it at both ends.

    end: the path speed at its end, ds/dt.
    """
    grid, profile = motion
    ends = np.vstack([grid.starts, end_of(grid)])[grid.borders]
    slopes, speeds = np.zeros_like(ends), np.zeros(len(grid.borders))
    speeds[0], speeds[-1] = profile.speeds[0], end
    slopes[0], slopes[-1] = grid.slopes[0] * (speeds[0] > 0.0), grid.slopes[-1] * (end > 0.0)
    ends[0] -= pause * speeds[0] * slopes[0]
    rests = grid.borders + np.arange(len(grid.borders))
    moving = np.ones(len(grid.steps) + len(rests), dtype=bool)
    moving[rests] = False

    def with_rests(rows: Array, at_rest: Array | float) -> Array:
        longer = np.empty((len(moving), *rows.shape[1:]))
        longer[moving], longer[rests] = rows, at_rest
        return longer

    path = with_rests(grid.starts, ends), with_rests(grid.slopes, slopes), with_rests(grid.bends, 0.0)
    steps = with_rests(grid.steps, pause * speeds)
    times = np.concatenate([[0.0], np.cumsum(with_rests(np.diff(profile.times), pause))])
    rates = (with_rests(rows, 0.0) for rows in profile[2:])
    return TimedPath(Grid(*path, steps, rests, grid.chords), Profile(times, with_rests(profile.speeds, speeds), *rates))
