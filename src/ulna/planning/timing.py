"""Finds the times of a path, and evaluates it at a time."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.planning.time_records import PathIntervals, Timing
from ulna.planning.blend import Grid
from ulna.planning.entries import time_parameterisation
from ulna.planning.path_limits import NO_LIMIT, PathBounds, PathLimit, along
from ulna.planning.positions import Farthest, farthest_of

Array = NDArray[np.float64]
INTERVALS = 200  # of a whole path; each piece has at least MIN_INTERVALS
MIN_INTERVALS = 8
_MAX_INTERVALS = 4000  # with more pieces than an eighth of these, each has fewer of its own
N_PHASES = 7  # of constant jerk, of a line from rest to rest
_ROUNDED = 1 + 1e-8  # of (ds/dt)^2 at the ends, which is measured
_WITHIN = 1 - 1e-9  # of the limits, so that rounding does not pass them
QUANTITIES = "position", "velocity", "acceleration", "jerk"  # of a Moment, in its order


class Moment(NamedTuple):
    """A moment of a trajectory: positions, velocities, accelerations and jerks, shape (..., n_dof) each."""

    q: Array
    qd: Array
    qdd: Array
    jerk: Array


class Limits(NamedTuple):
    """The greatest velocity, acceleration and jerk of each joint, shape (n_dof,) each; no limit of jerk for None."""

    velocity: Array
    acceleration: Array
    jerk: Array | None = None

    def wider(self, other: Limits) -> Limits:
        """The limits that a motion keeps of which one part keeps these, and another the others."""
        jerk = None if self.jerk is None or other.jerk is None else np.maximum(self.jerk, other.jerk)
        velocity, acceleration = map(np.maximum, self[:2], other[:2])
        return Limits(velocity, acceleration, jerk)


class Speeds(NamedTuple):
    """How fast a path is passed at its start and at its end, ds/dt [1/s]."""

    start: float
    end: float


AT_REST = Speeds(0.0, 0.0)


class Profile(NamedTuple):
    """How fast a path is passed: in interval i, t after times[i], with speeds + accelerations t + jerks t^2 / 2."""

    times: Array
    """When the grid points are passed [s], shape (n + 1,)."""
    speeds: Array
    accelerations: Array
    jerks: Array


class TimedPath(NamedTuple):
    """A path and how fast it is passed."""

    grid: Grid
    profile: Profile

    @property
    def times(self) -> Array:
        """When the grid points are passed [s], shape (n + 1,)."""
        return self.profile.times

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return float(self.profile.times[-1])

    @property
    def rests(self) -> Array:
        """When the motion is at rest [s]: at the start, at each stop, at the end."""
        return self.profile.times[self.grid.borders]

    @property
    def limits_jerk(self) -> bool:
        """Whether the acceleration goes on without jumps."""
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
        """The path passed slower: at time t where this one is at ``factor`` t."""
        times, speeds, accelerations, jerks = self.profile
        return TimedPath(self.grid, Profile(times / factor, speeds * factor, accelerations * factor**2, jerks * factor**3))

    def interval_at(self, t: Array) -> NDArray[np.int64]:
        """The interval in which each time lies, shape (...)."""
        return np.clip(np.searchsorted(self.profile.times, t, side="right") - 1, 0, len(self.grid.steps) - 1)

    def edges_since(self, t: float) -> tuple[Array, Array]:
        """The path from a time on as straight edges, shape (n, n_dof), n >= 2; and how far it lies beside each, (n - 1, n_dof).

        A line is one edge. In an interval of a parabola, h long, q differs from the chord by at most |bend| h^2 / 8.
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
        """Where it is farthest from a time on. An entry of a parabola turns at most once, where its slope is 0."""
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
    """Lines and parabolas divided into shorter intervals."""
    n, lengths = len(pieces.steps), pieces.steps
    few = np.where(pieces.bends.any(axis=1), pieces.chords, 1)  # those of a parabola are the chords along which it was certified
    least = np.maximum(few, min(MIN_INTERVALS, _MAX_INTERVALS // n))
    counts = np.maximum(least, np.ceil(INTERVALS * lengths / lengths.sum()))
    counts = counts.astype(np.int64)
    first = np.concatenate([[0], np.cumsum(counts)])
    steps = np.repeat(lengths / counts, counts)
    s = ((np.arange(len(steps)) - np.repeat(first[:-1], counts)) * steps)[:, None]
    starts, slopes, bends = (np.repeat(each, counts, axis=0) for each in pieces[:3])
    return Grid(starts + s * slopes + 0.5 * s * s * bends, slopes + s * bends, bends, steps, first[pieces.borders], pieces.chords)


def fastest(
    grid: Grid, velocity: Array, acceleration: Array, speeds: Speeds = AT_REST, slow: int = 0, caps: tuple[PathLimit, ...] = ()
) -> TimedPath | None:
    """The fastest motion, by TOPP-RA, which is no faster than at its start in the first ``slow`` intervals.

    None if the speeds at the ends cannot be had within the limits; from rest to rest there always is one.
    """
    bounds = along(caps, grid) if caps else None
    ceilings = _ceilings(grid, velocity, speeds, bounds)
    if slow:
        ceilings[: slow + 1] = np.minimum(ceilings[: slow + 1], speeds.start**2)
    timed, x = _timed(grid, acceleration, ceilings, speeds, bounds)
    return timed if _keeps(speeds, x) else None


def fastest_and_coasting(
    grid: Grid, velocity: Array, acceleration: Array, coast: float, speeds: Speeds = AT_REST, caps: tuple[PathLimit, ...] = ()
) -> tuple[TimedPath, ...]:
    """The fastest motion, and the fastest whose speed is constant for about ``coast`` [s] where that of the first has a peak.

    None, if the speeds at the ends cannot be had within the limits.
    """
    bounds = along(caps, grid) if caps else None
    ceilings = _ceilings(grid, velocity, speeds, bounds)
    first, x = _timed(grid, acceleration, ceilings, speeds, bounds)
    if not _keeps(speeds, x):
        return ()
    time_parameterisation.coasts(grid.steps, x, grid.borders, coast, ceilings)
    second, x = _timed(grid, acceleration, ceilings, speeds, bounds)
    return (first, second) if _keeps(speeds, x) else (first,)


def _keeps(speeds: Speeds, x: Array) -> bool:
    """Whether the motion has the speeds at the ends; x: (ds/dt)^2 at the grid points."""
    return bool(x[0] == speeds.start**2 and x[-1] * _ROUNDED >= speeds.end**2)


def _ceilings(grid: Grid, velocity: Array, speeds: Speeds, bounds: PathBounds | None) -> Array:
    """Greatest (ds/dt)^2 at the grid points by the limits of velocity and of caps, shape (n + 1,), with stops and ends."""
    steepest = np.maximum(np.abs(grid.slopes), np.abs(_ends(grid)))
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


def _ends(grid: Grid) -> Array:
    """The slopes at the ends of the intervals, shape (n, n_dof)."""
    return grid.slopes + grid.steps[:, None] * grid.bends


def _timed(
    grid: Grid, acceleration: Array, ceilings: Array, speeds: Speeds, bounds: PathBounds | None
) -> tuple[TimedPath, Array]:
    """The fastest motion below the ceilings of (ds/dt)^2, and what that is at the grid points, shape (n + 1,)."""
    n = len(grid.steps)
    most = np.tile(acceleration * _WITHIN, (n, 1))
    intervals = PathIntervals(grid.slopes, _ends(grid), grid.bends, -most, most, grid.steps)
    if bounds is not None and bounds.rows is not None:
        slopes, ends, bends, lows, highs = (np.hstack(pair) for pair in zip(intervals[:-1], bounds.rows, strict=True))
        intervals = PathIntervals(slopes, ends, bends, lows, highs, grid.steps)
    timing = Timing(np.zeros(n + 1), np.zeros(n), np.zeros(n + 1))
    timing.x[0] = speeds.start**2
    time_parameterisation.time_sections(intervals, ceilings, grid.borders, timing)
    return TimedPath(grid, Profile(timing.times, np.sqrt(timing.x[:-1]), timing.u, np.zeros(n))), timing.x


def along_lines(lines: Grid, velocity: Array, acceleration: Array, jerk: Array) -> TimedPath:
    """The fastest motion along lines, from rest to rest on each, in seven phases a line."""
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
    """The durations [s] of the seven phases of the fastest motion from rest to rest over a length, and the jerk in each.

    Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), section 3.4: the velocity has
    the form of two S.
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
