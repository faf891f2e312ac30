"""Switches from a running motion to another path.

A jerk-limited motion is the moving average, over a time w, of a base motion with limited acceleration. Up to a time t it depends
on its base only up to t + w. So the base is cut at t + w, and continues along a new path with its current velocity. The
acceleration of a base may jump; the moving average stays smooth.

The motion first continues straight for the distance that it needs, and then turns to the new path. If that is not free, it brakes
to a stop along its own path. From the stop it goes to the new path, if necessary via the path's start.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.planning.blend import Certificate, Grid, edges_of, end_of, find_free_cuts, is_motion_free, round_corners
from ulna.planning.boundary_velocities import STRAIGHT_ON, distinct_points, stopping_distance
from ulna.planning.jerk_limited import MAX_ATTEMPTS, REDUCTION, JerkLimited, add_pauses, max_deviation, min_window, timed_path
from ulna.planning.path_limits import PathLimit, peaks_of
from ulna.planning.positions import Farthest
from ulna.planning.spline_trajectory import SplineMotion
from ulna.planning.timing import N_PHASES, Limits, Moment, Profile, Speeds, TimedPath, grid_of, time_optimal

Array = NDArray[np.float64]
_BLEND = 0.1  # [rad]: blend of a corner of the plan, as in ``Plan.trajectory``
_MIN_SPEED = 1e-9  # [1/s]: a smaller speed counts as rest
_STOP_TOLERANCE = 1e-9  # [s]: a time nearer to a stop counts as the stop
_SHARES = 1.0, 0.7, 0.5, 0.35, 0.2  # shares of the acceleration that are tried
_BRAKING_FACTORS = 1.02, 2.0, 4.0  # braking distances along the own path, as multiples of the straight one
_LIMIT_TOLERANCE = 1 + 5e-10  # factor of the acceleration: a motion at its limit stays within it despite rounding
_PARTS = 64  # intervals per phase: averages over parts of long intervals would lose digits by cancellation
_WINDOW_TOLERANCE = 1 + 1e-6  # tolerance of the window's length relative to the jerk limits


@dataclass(frozen=True, eq=False)
class JoinedMotion:
    """A motion up to its end at rest, followed by another motion."""

    first: Timed
    then: Timed

    @property
    def limits_jerk(self) -> bool:
        """Whether both limit the jerk."""
        return self.first.limits_jerk and self.then.limits_jerk

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return self.first.duration + self.then.duration

    @property
    def times(self) -> Array:
        """The times at which the jerk changes [s]."""
        return np.concatenate([self.first.times[:-1], self.first.duration + self.then.times])

    @property
    def rests(self) -> Array:
        """The times at rest [s]."""
        return np.concatenate([self.first.rests[:-1], self.first.duration + self.then.rests])

    def at(self, t: Array) -> Moment:
        """The moments at times within the motion, shape (...)."""
        until = self.first.duration
        early, late = self.first.at(np.minimum(t, until)), self.then.at(np.maximum(t - until, 0.0))
        return Moment(*(np.where((t < until)[..., None], *both) for both in zip(early, late, strict=True)))

    def slowed(self, factor: float) -> JoinedMotion:
        """A slower motion: at time t it is where this one is at ``factor`` t."""
        return JoinedMotion(self.first.slowed(factor), self.then.slowed(factor))

    def farthest(self, since: float) -> Farthest:
        """The extreme positions from a time on."""
        until = self.first.duration
        later = self.then.farthest(max(since - until, 0.0))
        later = later._replace(times=later.times + until)
        return later if since >= until else self.first.farthest(since).joined(later)

    def edges_since(self, t: float) -> tuple[Array, Array]:
        """The motion from a time on as straight edges, and its largest distance from each."""
        if t >= self.first.duration:
            return self.then.edges_since(t - self.first.duration)
        (early, late), (deviation, others) = zip(self.first.edges_since(t), self.then.edges_since(0.0), strict=True)
        return np.concatenate([early, late[1:]]), np.concatenate([deviation, others])


Timed = TimedPath | JerkLimited | JoinedMotion | SplineMotion


def is_from_file(timed: Timed) -> bool:
    """Whether a motion, or a part of it, is a spline read from a file."""
    return (
        is_from_file(timed.first) or is_from_file(timed.then)
        if isinstance(timed, JoinedMotion)
        else isinstance(timed, SplineMotion)
    )


def switch_path(timed: Timed, path: Array, at: float, limits: Limits, certificate: Certificate) -> Timed:
    """The motion up to a time, and from there along a path, shape (n, n_dof), that begins at its position.

    Raises:
        InputError: No transition to the path is free.
    """
    found = _switch(timed, path if len(path) > 1 else np.repeat(path, 2, axis=0), at, limits, certificate)
    if found is None:
        raise InputError(
            "plan",
            f"no transition to it at {at:.6g} s is within the limits and certified free, neither straight on nor along "
            "the motion's own path; plan from another time",
        )
    return found


def _switch(timed: Timed, path: Array, at: float, limits: Limits, certificate: Certificate) -> Timed | None:
    """``switch_path``; None if no transition to the path is free."""
    begin = timed.at(np.array(0.0))
    if at <= _STOP_TOLERANCE and np.linalg.norm(begin.qd) <= _MIN_SPEED:
        return _start_from_rest(begin.q, path, limits, certificate)
    if isinstance(timed, JoinedMotion):
        if at < timed.first.duration:
            return _switch(timed.first, path, at, limits, certificate)
        then = _switch(timed.then, path, at - timed.first.duration, limits, certificate)
        return None if then is None else JoinedMotion(timed.first, then)
    if isinstance(timed, SplineMotion):
        raise AssertionError("a motion from a file is not replaced")  # noqa: TRY004 - the caller has asked
    if isinstance(timed, JerkLimited) or limits.jerk is None:
        return _leave_moving(timed, path, at, limits, certificate)
    k = int(np.searchsorted(timed.rests, at + _STOP_TOLERANCE, side="right")) - 1
    begin = float(timed.rests[k])
    before = _cut_between_rests(timed, 0, k) if begin else None
    if at <= begin + _STOP_TOLERANCE:
        then = _start_from_rest(timed.at(np.array(begin)).q, path, limits, certificate)
    else:
        then = _leave_line(_cut_between_rests(timed, k, k + 1), path, at - begin, limits, certificate)
    return then if then is None or before is None else JoinedMotion(before, then)


def _cut_between_rests(motion: TimedPath, first: int, last: int) -> TimedPath:
    """The part of a motion between two of its stops."""
    i, k = motion.grid.borders[[first, last]].tolist()
    starts, slopes, bends, steps = (each[i:k] for each in motion.grid[:4])
    times, *rates = motion.profile
    grid = Grid(starts, slopes, bends, steps, motion.grid.borders[first : last + 1] - i, motion.grid.chords)
    return TimedPath(grid, Profile(times[i : k + 1] - times[i], *(each[i:k] for each in rates)))


def _start_from_rest(q: Array, path: Array, limits: Limits, certificate: Certificate) -> TimedPath | JerkLimited | None:
    """A motion from rest at q to a path's second point, or via its start; None if neither is free."""
    for points in (distinct_points(np.stack([q, *path[1:]])), distinct_points(np.stack([q, *path]))):
        if len(points) > 1:
            lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
            motion = timed_path(points, lengths, _BLEND, limits, certificate)
            if motion is not None and is_motion_free(certificate, motion, 0.0):
                return motion
    return None


def _leave_line(line: TimedPath, path: Array, at: float, limits: Limits, certificate: Certificate) -> Timed | None:
    """A transition from a line with seven phases, before its end or from the stop at its end."""
    turned = _leave_moving(line, path, at, limits, certificate)
    if turned is not None or not is_motion_free(certificate, line, at):
        return turned
    then = _start_from_rest(line.at(np.array(line.duration)).q, path, limits, certificate)
    return None if then is None else JoinedMotion(line, then)


def _leave_moving(
    timed: TimedPath | JerkLimited, path: Array, at: float, limits: Limits, certificate: Certificate
) -> TimedPath | JerkLimited | None:
    """A transition from a moving motion: straight on, or after braking along its own path; None if none is free."""
    base, window = _base_and_window(timed)
    stops: list[tuple[TimedPath, list[Grid]]] | None = None
    rest = certificate._replace(caps=())  # ``_continue_base`` checks the limits of hands
    for share in _SHARES:
        for way in _straight_continuations(base, at + window, path, window, share * limits.acceleration, certificate):
            motion = _continue_base(base, window, at, way, share, limits, certificate)
            if motion is not None and is_motion_free(rest, motion, at):
                return motion
        stops = list(_brake(base, window, at, path, limits, certificate)) if stops is None else stops
        for stopped, grids in stops:
            for grid in grids:
                again = float(stopped.times[-1]) - window
                motion = _continue_base(stopped, window, again, _Continuation(grid, 0.0), share, limits, certificate)
                if motion is not None and is_motion_free(rest, motion, at):
                    return motion
    return None


class _Continuation(NamedTuple):
    """A continuation of a base motion."""

    grid: Grid
    speed: float
    """The speed at its start, ds/dt."""
    slow: int = 0
    """The number of first intervals in which the speed must not exceed ``speed``."""


def _straight_continuations(
    base: TimedPath, time: float, path: Array, window: float, acceleration: Array, certificate: Certificate
) -> Iterator[_Continuation]:
    """Yield continuations of a base from a time: straight on, and then to a path."""
    begin = base.at(np.array(time))
    speed = float(np.linalg.norm(begin.qd))
    for more in STRAIGHT_ON if speed > _MIN_SPEED else ():
        along = begin.qd / speed
        # the window's length is added, so that the acceleration does not change twice within it
        ahead = more * _stopping_distance(begin, acceleration, certificate.caps) + speed * window
        points = [begin.q, begin.q + ahead * along, *path[1:]]
        for grid in _round_path(points, max(_BLEND, ahead), certificate):
            yield _Continuation(grid, speed, int(np.argmax(np.append(grid.bends.any(axis=1), True))))  # up to the first parabola
    if speed <= _MIN_SPEED:
        yield from (_Continuation(grid, 0.0) for grid in _round_path([begin.q, *path[1:]], _BLEND, certificate))


def _stopping_distance(begin: Moment, acceleration: Array, caps: tuple[PathLimit, ...]) -> float:
    """The straight braking distance within limits of acceleration, and approximately within limits of hands."""
    speed = float(np.linalg.norm(begin.qd))
    own = stopping_distance(begin.qd / speed, speed, acceleration)
    return max(own, *(cap.stopping_distance(begin.q, begin.qd) for cap in caps)) if caps else own


def _round_path(points: list[Array], blend: float, certificate: Certificate) -> list[Grid]:
    """The path along points, with corners rounded where that is free; an empty list if the points are equal."""
    path = distinct_points(np.stack(points))
    if len(path) == 1:
        return []
    edges = edges_of(path, np.linalg.norm(np.diff(path, axis=0), axis=1), certificate.chords)
    return [grid_of(round_corners(edges, find_free_cuts(edges, blend, certificate)))]


def _brake(
    base: TimedPath, window: float, at: float, path: Array, limits: Limits, certificate: Certificate
) -> Iterator[tuple[TimedPath, list[Grid]]]:
    """Yield bases that brake to a stop along their own path, each with the continuations from there to a path.

    The last continuations go back along the own path.
    """
    begin = base.at(np.array(at + window))
    speed = float(np.linalg.norm(begin.qd))
    if speed <= _MIN_SPEED:
        return
    left, rate = _remaining_path(base, at + window)
    for more in _BRAKING_FACTORS:
        for share in (_LIMIT_TOLERANCE, *_SHARES[1:]):
            stop = _stopping_distance(begin, share * limits.acceleration, certificate.caps) + speed * window
            braking = _cut_path(left, more * stop * rate / speed)
            stopped = _continue_base(
                base, window, at, _Continuation(braking, rate, len(braking.steps)), share, limits, certificate
            )
            if stopped is not None:
                joined = stopped.base if isinstance(stopped, JerkLimited) else stopped
                back = _reverse(_remaining_path(joined, at + 0.5 * window)[0])
                end = joined.at(joined.times[-1:]).q[0]
                ways = [*_round_path([end, *path[1:]], _BLEND, certificate), *_round_path([end, *path], _BLEND, certificate)]
                start = _round_path([end_of(back), path[0]], 0.0, certificate)
                then = (_round_path([*path], blend, certificate) for blend in (_BLEND, 0.0))
                ways += [reduce(_join_grids, [*start, *grids], back) for grids in then]
                yield joined, ways
                break


def _remaining_path(motion: TimedPath, time: float) -> tuple[Grid, float]:
    """The rest of the path from a time to the next stop, and the speed at that time, ds/dt."""
    (starts, slopes, bends, steps, borders, chords), i = motion.grid, int(motion.interval_at(np.array(time)))
    profile, after = motion.profile, time - motion.times[i]
    s = (0.5 * profile.accelerations[i] * after + profile.speeds[i]) * after
    k = next(iter(borders[borders > i].tolist()), len(steps))  # up to the end if the motion does not stop there
    rows = [each[i:k].copy() for each in (starts, slopes, bends, steps)]
    rows[0][0] += s * (slopes[i] + 0.5 * s * bends[i])
    rows[1][0] += s * bends[i]
    rows[3][0] -= s
    moving = rows[3] > 0.0  # excludes rests and rounding of a cut interval
    starts, slopes, bends, steps = (each[moving] for each in rows)
    path = Grid(starts, slopes, bends, steps, np.array([0, len(steps)]), chords)
    return path, float(profile.speeds[i] + profile.accelerations[i] * after)


def _cut_path(path: Grid, length: float) -> Grid:
    """The path cut at a length; the whole path if it is shorter."""
    ends = np.cumsum(path.steps)
    n = min(int(np.searchsorted(ends, length)) + 1, len(ends))
    starts, slopes, bends, steps = (each[:n].copy() for each in path[:4])
    steps[-1] -= max(ends[n - 1] - length, 0.0)
    return Grid(starts, slopes, bends, steps, np.array([0, n]), path.chords)


def _reverse(path: Grid) -> Grid:
    """The reversed path."""
    starts, slopes, bends, steps, borders, chords = path
    s = steps[:, None]
    ends = starts + s * (slopes + 0.5 * s * bends), -(slopes + s * bends)
    starts, slopes, bends, steps = (np.ascontiguousarray(each[::-1]) for each in (*ends, bends, steps))
    return Grid(starts, slopes, bends, steps, borders, chords)


def _join_grids(first: Grid, then: Grid) -> Grid:
    """Join two paths, with a stop between them."""
    starts, slopes, bends, steps = (np.concatenate([early, late]) for early, late in zip(first[:4], then[:4], strict=True))
    borders = np.concatenate([first.borders[:-1], then.borders + len(first.steps)])
    return Grid(starts, slopes, bends, steps, borders, max(first.chords, then.chords))


def _base_and_window(timed: TimedPath | JerkLimited) -> tuple[TimedPath, float]:
    """The base of a motion, and the window of the moving average.

    Without a jerk limit they are the motion itself and 0. A motion along a line in seven phases is the moving average of one in
    three phases, over the time of constant jerk.
    """
    if isinstance(timed, JerkLimited):
        return timed.base, timed.window
    if not timed.limits_jerk:
        return timed, 0.0
    grid, (times, _, _, jerks) = timed
    growing, steady, _, cruising = np.diff(times)[: N_PHASES // 2 + 1]
    rate, speeding = jerks[0] * growing, growing + steady
    coasting = cruising + growing
    phases = np.repeat([speeding, coasting, speeding], _PARTS) / _PARTS
    rates = np.repeat([rate, 0.0, -rate], _PARTS)
    speeds = np.concatenate([[0.0], np.cumsum(rates * phases)[:-1]])
    steps = (0.5 * rates * phases + speeds) * phases
    s = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
    slopes = np.repeat(grid.slopes[:1], len(steps), axis=0)
    starts, still = grid.starts[0] + s[:, None] * slopes, np.zeros_like(slopes)
    base = Grid(starts, slopes, still, steps, np.array([0, len(steps)]), grid.chords)
    profile = Profile(np.concatenate([[0.0], np.cumsum(phases)]), speeds, rates, np.zeros(len(steps)))
    return add_pauses(TimedPath(base, profile), float(growing)), float(growing)


def _continue_base(
    base: TimedPath, window: float, at: float, way: _Continuation, share: float, limits: Limits, certificate: Certificate
) -> TimedPath | JerkLimited | None:
    """The moving average of the base up to at + window and a continuation; None if it exceeds limits."""
    caps = certificate.caps
    narrower = (
        caps if limits.jerk is None else tuple(cap.with_less_acceleration(share) for cap in caps)
    )  # like joints, for the window
    for _ in range(MAX_ATTEMPTS if caps else 1):
        motion = _average(base, window, at, way, limits._replace(acceleration=share * limits.acceleration), narrower)
        peaks = () if motion is None else peaks_of(motion, caps, at)
        if all(peaks):
            return replace(motion, deviation=max_deviation(certificate)) if isinstance(motion, JerkLimited) else motion
        narrower = tuple(cap.narrowed(peaks, REDUCTION) for cap in narrower)
    return None


def _average(
    base: TimedPath, window: float, at: float, way: _Continuation, limits: Limits, caps: tuple[PathLimit, ...]
) -> TimedPath | JerkLimited | None:
    rest = time_optimal(way.grid, limits.velocity, limits.acceleration, Speeds(way.speed, 0.0), way.slow, caps)
    if rest is None:
        return None
    if window == 0.0:
        return _join(base, at, rest)
    joined = _join(base, at + window, _add_later_pauses(rest, window))
    if limits.jerk is None or min_window(joined, limits.jerk, window) > window * _WINDOW_TOLERANCE:
        return None
    return JerkLimited(joined, window)


def _add_later_pauses(motion: TimedPath, pause: float) -> TimedPath:
    """The motion with a pause [s] at each stop and at its end, but none at its start."""
    (starts, slopes, bends, steps, borders, chords), profile = add_pauses(motion, pause)
    path = Grid(starts[1:], slopes[1:], bends[1:], steps[1:], np.concatenate([[0], borders[1:] - 1]), chords)
    return TimedPath(path, Profile(profile.times[1:] - pause, *(rows[1:] for rows in profile[1:])))


def _join(first: TimedPath, until: float, then: TimedPath) -> TimedPath:
    """The first motion up to a time, followed by another motion that begins there."""
    i = int(first.interval_at(np.array(until)))
    after = until - first.times[i]
    step = (0.5 * first.profile.accelerations[i] * after + first.profile.speeds[i]) * after
    starts, slopes, bends = [
        np.concatenate([early[: i + 1], late]) for early, late in zip(first.grid[:3], then.grid[:3], strict=True)
    ]
    steps = np.concatenate([first.grid.steps[:i], [step], then.grid.steps])
    borders = np.concatenate([first.grid.borders[first.grid.borders <= i], then.grid.borders[1:] + i + 1])
    times = np.concatenate([first.times[: i + 1], until + then.times])
    profile = [np.concatenate([early[: i + 1], late]) for early, late in zip(first.profile[1:], then.profile[1:], strict=True)]
    path = Grid(starts, slopes, bends, steps, borders, max(first.grid.chords, then.grid.chords))
    return TimedPath(path, Profile(times, *profile))
