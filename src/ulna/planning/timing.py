"""Computes time parameterizations of paths, and evaluates the resulting motions."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.planning.time_records import PathIntervals, Timing
from ulna.planning.blend import Grid
from ulna.planning.entries import time_parameterization
from ulna.planning.path_limits import NO_LIMIT, PathBounds, PathLimit, along
from ulna.planning.positions import Farthest, farthest_of

Array = NDArray[np.float64]
INTERVALS = 200  # target number of intervals of a whole path
MIN_INTERVALS = 8  # per piece
_MAX_INTERVALS = 4000  # beyond this number, pieces have fewer than MIN_INTERVALS
N_PHASES = 7  # phases of constant jerk of a line from rest to rest
_ROUNDED = 1 + 1e-8  # relative tolerance of (ds/dt)^2 at the ends
_WITHIN = 1 - 1e-9  # factor of the limits, so that rounding does not exceed them
QUANTITIES = "position", "velocity", "acceleration", "jerk"  # the fields of a Moment, in order


class Moment(NamedTuple):
    """The state of a motion at a time: positions, velocities, accelerations and jerks, shape (..., n_dof) each."""

    q: Array
    qd: Array
    qdd: Array
    jerk: Array


class Limits(NamedTuple):
    """The maximum velocity, acceleration and jerk of each joint, shape (n_dof,) each; None for no jerk limit."""

    velocity: Array
    acceleration: Array
    jerk: Array | None = None

    def wider(self, other: Limits) -> Limits:
        """The wider of two limits, which hold for two joined motions."""
        jerk = None if self.jerk is None or other.jerk is None else np.maximum(self.jerk, other.jerk)
        velocity, acceleration = map(np.maximum, self[:2], other[:2])
        return Limits(velocity, acceleration, jerk)


class Speeds(NamedTuple):
    """The path speeds at the start and at the end, ds/dt [1/s]."""

    start: float
    end: float


AT_REST = Speeds(0.0, 0.0)


class Profile(NamedTuple):
    """The path speed ds/dt: speeds + accelerations t + jerks t^2 / 2 in interval i, with t from times[i]."""

    times: Array
    """The times of the grid points [s], shape (n + 1,)."""
    speeds: Array
    accelerations: Array
    jerks: Array


class TimedPath(NamedTuple):
    """A path with its time parameterization."""

    grid: Grid
    profile: Profile

    @property
    def times(self) -> Array:
        """The times of the grid points [s], shape (n + 1,)."""
        return self.profile.times

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return float(self.profile.times[-1])

    @property
    def rests(self) -> Array:
        """The times at rest [s]: the start, each stop, and the end."""
        return self.profile.times[self.grid.borders]

    @property
    def limits_jerk(self) -> bool:
        """Whether the acceleration is continuous."""
        return bool(self.profile.jerks.any())

    def at(self, t: Array) -> Moment:
        """The moments at times within the motion, shape (...)."""
        (grid, profile), i = self, self.interval_at(t)
        after = t - profile.times[i]
        speed, rate, jerk = profile.speeds[i], profile.accelerations[i], profile.jerks[i]
        s = np.clip(((jerk / 6 * after + rate / 2) * after + speed) * after, 0.0, np.maximum(grid.steps[i], 0.0))[..., None]
        speed, rate = ((jerk / 2 * after + rate) * after + speed)[..., None], (jerk * after + rate)[..., None]
        bend = grid.bends[i]
        slope = grid.slopes[i] + s * bend
        q = grid.starts[i] + s * grid.slopes[i] + 0.5 * s * s * bend
        return Moment(q, slope * speed, slope * rate + bend * speed**2, slope * jerk[..., None] + 3 * bend * speed * rate)

    def slowed(self, factor: float) -> TimedPath:
        """A slower motion: at time t it is where this one is at ``factor`` t."""
        times, speeds, accelerations, jerks = self.profile
        return TimedPath(self.grid, Profile(times / factor, speeds * factor, accelerations * factor**2, jerks * factor**3))

    def interval_at(self, t: Array) -> NDArray[np.int64]:
        """The index of the interval that contains each time, shape (...)."""
        return np.clip(np.searchsorted(self.profile.times, t, side="right") - 1, 0, len(self.grid.steps) - 1)

    def edges_since(self, t: float) -> tuple[Array, Array]:
        """The path from a time on as straight edges, shape (n, n_dof), and its distances, (n - 1, n_dof).

        There are at least two points. A line is one edge. In an interval of a parabola of length h, q differs from the chord by
        at most |bend| h^2 / 8.
        """
        times = np.concatenate([[t], self.times[self.times > t]])
        times = times if len(times) > 1 else np.repeat(times, 2)
        of = self.interval_at(times[:-1])
        bends, slopes = self.grid.bends[of], self.grid.slopes[of]
        on = (bends[1:] == 0.0).all(axis=1) & (bends[:-1] == 0.0).all(axis=1) & (slopes[1:] == slopes[:-1]).all(axis=1)
        ends = np.concatenate([[True], ~on, [True]])
        spreads = np.abs(bends) * self.grid.steps[of][:, None] ** 2 / 8 * (1 + 1e-9)
        return self.at(times).q[ends], spreads[ends[:-1]]

    def farthest(self, since: float) -> Farthest:
        """The extreme positions from a time on: at grid points, and where the slope of a parabola's entry is 0."""
        (starts, slopes, bends, steps, *_), (_, speeds, rates, _) = self
        times = np.concatenate([[since], self.times[self.times > since]])
        found = farthest_of(self.at(times).q, times)
        i, k = np.nonzero(slopes * (slopes + steps[:, None] * bends) < 0.0)
        s = -slopes[i, k] / bends[i, k]
        speed = speeds[i] + np.sqrt(np.maximum(speeds[i] ** 2 + 2.0 * rates[i] * s, 0.0))
        turns = self.times[:-1][i] + np.where(speed > 0.0, 2.0 * s / np.where(speed > 0.0, speed, 1.0), 0.0)
        later = turns > since
        if not later.any():
            return found
        i, k, s, turns = i[later], k[later], s[later], turns[later]
        q, at = np.tile(self.at(np.array(since)).q, (len(i), 1)), np.full((len(i), starts.shape[1]), since)
        q[np.arange(len(i)), k], at[np.arange(len(i)), k] = starts[i, k] + 0.5 * s * slopes[i, k], turns
        return found.joined(farthest_of(q, at))


def grid_of(pieces: Grid) -> Grid:
    """Divide lines and parabolas into shorter intervals."""
    n, lengths = len(pieces.steps), pieces.steps
    few = np.where(pieces.bends.any(axis=1), pieces.chords, 1)  # at least the chords with which a parabola was certified
    least = np.maximum(few, min(MIN_INTERVALS, _MAX_INTERVALS // n))
    counts = np.maximum(least, np.ceil(INTERVALS * lengths / lengths.sum()))
    counts = counts.astype(np.int64)
    first = np.concatenate([[0], np.cumsum(counts)])
    steps = np.repeat(lengths / counts, counts)
    s = ((np.arange(len(steps)) - np.repeat(first[:-1], counts)) * steps)[:, None]
    starts, slopes, bends = (np.repeat(each, counts, axis=0) for each in pieces[:3])
    return Grid(starts + s * slopes + 0.5 * s * s * bends, slopes + s * bends, bends, steps, first[pieces.borders], pieces.chords)


def time_optimal(
    grid: Grid, velocity: Array, acceleration: Array, speeds: Speeds = AT_REST, slow: int = 0, caps: tuple[PathLimit, ...] = ()
) -> TimedPath | None:
    """The time-optimal motion along a path, by TOPP-RA; in the first ``slow`` intervals it must not exceed its start speed.

    None if the speeds at the ends are not possible within the limits; from rest to rest a motion always exists.
    """
    bounds = along(caps, grid) if caps else None
    ceilings = _ceilings(grid, velocity, speeds, bounds)
    if slow:
        ceilings[: slow + 1] = np.minimum(ceilings[: slow + 1], speeds.start**2)
    timed, x = _parameterize(grid, acceleration, ceilings, speeds, bounds)
    return timed if _reaches_speeds(speeds, x) else None


def time_optimal_and_coasting(
    grid: Grid, velocity: Array, acceleration: Array, coast: float, speeds: Speeds = AT_REST, caps: tuple[PathLimit, ...] = ()
) -> tuple[TimedPath, ...]:
    """The time-optimal motion, and one that coasts: each peak of its speed is flat for about ``coast`` [s].

    An empty tuple if the speeds at the ends are not possible within the limits.
    """
    bounds = along(caps, grid) if caps else None
    ceilings = _ceilings(grid, velocity, speeds, bounds)
    first, x = _parameterize(grid, acceleration, ceilings, speeds, bounds)
    if not _reaches_speeds(speeds, x):
        return ()
    time_parameterization.insert_coasts(grid.steps, x, grid.borders, coast, ceilings)
    second, x = _parameterize(grid, acceleration, ceilings, speeds, bounds)
    return (first, second) if _reaches_speeds(speeds, x) else (first,)


def _reaches_speeds(speeds: Speeds, x: Array) -> bool:
    """Whether a motion has the given speeds at its ends. x: (ds/dt)^2 at the grid points."""
    return bool(x[0] == speeds.start**2 and x[-1] * _ROUNDED >= speeds.end**2)


def _ceilings(grid: Grid, velocity: Array, speeds: Speeds, bounds: PathBounds | None) -> Array:
    """The maximum (ds/dt)^2 at the grid points by limits of velocity and caps, shape (n + 1,); 0 at stops."""
    steepest = np.maximum(np.abs(grid.slopes), np.abs(_end_slopes(grid)))
    with np.errstate(divide="ignore", over="ignore"):
        of_intervals = np.minimum((velocity * _WITHIN / steepest).min(axis=1), 1e150) ** 2
    ceilings = np.full(len(grid.steps) + 1, NO_LIMIT)
    ceilings[:-1] = np.minimum(ceilings[:-1], of_intervals)
    ceilings[1:] = np.minimum(ceilings[1:], of_intervals)
    if bounds is not None:
        ceilings[:-1] = np.minimum(ceilings[:-1], bounds.before)
        ceilings[1:] = np.minimum(ceilings[1:], bounds.behind)
    ceilings[grid.borders[1:-1]] = 0.0
    for end, square in ((0, speeds.start**2), (-1, speeds.end**2)):
        ceilings[end] = square if square <= ceilings[end] * _ROUNDED else 0.0
    return ceilings


def _end_slopes(grid: Grid) -> Array:
    """The slopes q' at the ends of the intervals, shape (n, n_dof)."""
    return grid.slopes + grid.steps[:, None] * grid.bends


def _parameterize(
    grid: Grid, acceleration: Array, ceilings: Array, speeds: Speeds, bounds: PathBounds | None
) -> tuple[TimedPath, Array]:
    """The time-optimal motion below ceilings of (ds/dt)^2, and (ds/dt)^2 at the grid points, shape (n + 1,)."""
    n = len(grid.steps)
    most = np.tile(acceleration * _WITHIN, (n, 1))
    intervals = PathIntervals(grid.slopes, _end_slopes(grid), grid.bends, -most, most, grid.steps)
    if bounds is not None and bounds.rows is not None:
        slopes, ends, bends, lows, highs = (np.hstack(pair) for pair in zip(intervals[:-1], bounds.rows, strict=True))
        intervals = PathIntervals(slopes, ends, bends, lows, highs, grid.steps)
    timing = Timing(np.zeros(n + 1), np.zeros(n), np.zeros(n + 1))
    timing.x[0] = speeds.start**2
    time_parameterization.time_sections(intervals, ceilings, grid.borders, timing)
    return TimedPath(grid, Profile(timing.times, np.sqrt(timing.x[:-1]), timing.u, np.zeros(n))), timing.x


def follow_lines(lines: Grid, velocity: Array, acceleration: Array, jerk: Array) -> TimedPath:
    """The fastest motion along lines, from rest to rest, in seven phases of constant jerk per line."""
    rows = []
    for start, slope, length in zip(lines.starts, lines.slopes, lines.steps, strict=True):
        with np.errstate(divide="ignore"):
            along = tuple(float(np.min(limit * _WITHIN / np.abs(slope))) for limit in (velocity, acceleration, jerk))
        durations, jerks = double_s(length, *along)
        s = speed = rate = 0.0
        for t, j in zip(durations, jerks, strict=True):
            step = speed * t + rate * t * t / 2 + j * t**3 / 6
            rows.append((start + s * slope, slope, step, t, speed, rate, j))
            s, speed, rate = s + step, speed + rate * t + j * t * t / 2, rate + j * t
    starts, slopes, steps, times, *others = (np.array(column) for column in zip(*rows, strict=True))
    grid = Grid(starts, slopes, np.zeros_like(slopes), steps, np.arange(0, len(rows) + 1, N_PHASES), lines.chords)
    return TimedPath(grid, Profile(np.concatenate([[0.0], np.cumsum(times)]), *others))


def double_s(length: float, velocity: float, acceleration: float, jerk: float) -> tuple[Array, Array]:
    """The durations [s] and jerks of the seven phases of the fastest motion from rest to rest over a length.

    Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), section 3.4 (double S velocity
    profile).
    """
    peak, top = velocity, acceleration
    if peak * jerk < top * top:  # the velocity is reached before the acceleration
        top = math.sqrt(peak * jerk)
    if peak * (peak / top + top / jerk) > length:  # the velocity is not reached
        peak = 0.5 * acceleration * (math.sqrt((acceleration / jerk) ** 2 + 4 * length / acceleration) - acceleration / jerk)
        top = acceleration
        if peak * jerk < top * top:
            peak = (0.25 * length * length * jerk) ** (1 / 3)
            top = math.sqrt(peak * jerk)
    bending, steady = top / jerk, max(peak / top - top / jerk, 0.0)
    cruise = max(length / peak - (steady + 2 * bending), 0.0)
    durations = np.array([bending, steady, bending, cruise, bending, steady, bending])
    return durations, jerk * np.array([1.0, 0, -1, 0, -1, 0, 1])
