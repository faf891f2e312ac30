"""Goes over from a motion that runs to another path.

A motion within limits of jerk is a mean over a time w of one within limits of acceleration, its base. Up to a time t it depends
on its base up to t + w alone. So the base is cut there, and goes on along a new path with the velocity that it has: the
acceleration of a base may jump, and its mean is as smooth after t as before.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.planning.averaged import Averaged, least_window_of, with_pauses
from ulna.planning.blend import Grid, IsFree, free_cuts, rounded
from ulna.planning.timing import N_PHASES, Limits, Profile, TimedPath, fastest_from, grid_of

Array = NDArray[np.float64]
_BLEND = 0.1  # [rad]: of a corner of the plan, as that of a trajectory
_STANDS = 1e-9  # [1/s]: a speed below it is none
_SHARES = 1.0, 0.7, 0.5, 0.35, 0.2  # of the acceleration
_STRAIGHT_ON = 1.02, 1.5, 2.5, 4.0  # of the distance in which the motion would stop
_PARTS = 64  # of each phase: a mean over part of a long interval is the small difference of large areas
_ROUNDED = 1 + 1e-6  # of the window, which is as much longer than the limits of jerk need


def replaced(timed: TimedPath | Averaged, path: Array, at: float, limits: Limits, is_free: IsFree) -> TimedPath | Averaged:
    """The motion up to a time, and then along a path, shape (n, n_dof), which begins where the motion is then.

    Raises:
        InputError: The motion stops at corners, and the time is not at a stop; or no way into the path is free.
    """
    base, window = _base_of(timed, at)
    begin = base.at(np.array(at + window))
    speed = float(np.linalg.norm(begin.qd))
    for share, more in product(_SHARES, _STRAIGHT_ON):
        if speed > _STANDS:
            along = begin.qd / speed
            stop = 0.5 * speed**2 * float((np.abs(along) / (share * limits.acceleration)).max())
            ahead = more * stop + speed * window  # the acceleration does not change twice within the window
            points, blend = np.vstack([begin.q, begin.q + ahead * along, path[1:]]), max(_BLEND, ahead)
        else:
            speed, points, blend = 0.0, np.vstack([begin.q, path[1:]]), _BLEND
        motion = _with_path(base, window, at, _without_equal(points), blend, speed, share, limits, is_free)
        if motion is not None and is_free(*motion.edges_since(at)):
            return motion
    raise InputError(
        "plan",
        f"at {at:.6g} s the motion cannot go over into it: no way straight on and from there into its path is within the limits "
        "and certified free; plan from another time",
    )


def _base_of(timed: TimedPath | Averaged, at: float) -> tuple[TimedPath, float]:
    """The base of a motion, and the time w over which the motion is its mean; 0 for the motion itself.

    A motion along a line in seven phases is the mean of one in three, over the time in which its acceleration grows.
    """
    if isinstance(timed, Averaged):
        return timed.base, timed.window
    if not timed.limits_jerk:
        return timed, 0.0
    if len(timed.rests) > 2:
        raise InputError("at", f"{at:.6g}; a motion that stops at every corner within a limit of jerk cannot be replaced")
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
    base = Grid(grid.starts[0] + s[:, None] * slopes, slopes, np.zeros_like(slopes), steps, np.array([0, len(steps)]))
    profile = Profile(np.concatenate([[0.0], np.cumsum(phases)]), speeds, rates, np.zeros(len(steps)))
    return with_pauses(TimedPath(base, profile), float(growing)), float(growing)


def _without_equal(points: Array) -> Array:
    """The points without those that equal the one before."""
    return points[np.concatenate([[True], np.abs(np.diff(points, axis=0)).max(axis=1) > 0.0])]


def _with_path(
    base: TimedPath, window: float, at: float, points: Array, blend: float, speed: float, share: float, limits: Limits,
    is_free: IsFree,
) -> TimedPath | Averaged | None:  # fmt: skip
    """The base up to at + window and then along the points, and its mean; None if it cannot be within the limits."""
    if len(points) == 1:
        return None
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    cuts = free_cuts(points, lengths, blend, is_free)
    rest = fastest_from(grid_of(rounded(points, lengths, cuts)), limits.velocity, share * limits.acceleration, speed)
    if rest is None:
        return None
    if window == 0.0:
        return _joined(base, at, rest)
    joined = _joined(base, at + window, _with_later_pauses(rest, window))
    if limits.jerk is None or least_window_of(joined, limits.jerk, window) > window * _ROUNDED:
        return None
    return Averaged(joined, window)


def _with_later_pauses(motion: TimedPath, pause: float) -> TimedPath:
    """The motion with a rest of so long [s] at each stop and at its end, but none at its start."""
    (starts, slopes, bends, steps, borders), profile = with_pauses(motion, pause)
    path = Grid(starts[1:], slopes[1:], bends[1:], steps[1:], np.concatenate([[0], borders[1:] - 1]))
    return TimedPath(path, Profile(profile.times[1:] - pause, *(rows[1:] for rows in profile[1:])))


def _joined(first: TimedPath, until: float, then: TimedPath) -> TimedPath:
    """The first motion up to a time, and then the other, which begins where that is."""
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
    return TimedPath(Grid(starts, slopes, bends, steps, borders), Profile(times, *profile))
