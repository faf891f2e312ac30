"""Makes motions with velocities at their start or end, which enter and leave a path straight."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError
from ulna.planning.blend import Certificate, is_path_free
from ulna.planning.jerk_limited import JerkLimited, timed_path
from ulna.planning.positions import PositionLimits, farthest_of
from ulna.planning.timing import AT_REST, Limits, Speeds, TimedPath

Array = NDArray[np.float64]
STRAIGHT_ON = 1.02, 1.5, 2.5, 4.0  # lengths of the straight part, as multiples of the braking distance
_ALONG = 1e-9  # difference of directions below which a velocity is along an edge
_ABOVE = 1 + 1e-9  # tolerance of a velocity limit, for rounding


class Ends(NamedTuple):
    """The velocities at the ends of a motion [rad/s or m/s], shape (n_dof,) each; 0 at rest."""

    start: Array
    end: Array


def as_ends(
    start: ArrayLike | None, end: ArrayLike | None, path: Array, limits: Limits, positions: PositionLimits, names: Sequence[str]
) -> Ends:
    """Check given velocities at the ends of a path, shape (n, n_dof); None for rest.

    Raises:
        InputError: A velocity is not n_dof finite numbers, exceeds its limit, or a joint could not stop within its range.
    """
    ends = Ends(*(_as_velocity(*each, limits, names) for each in (("start_velocity", start), ("end_velocity", end))))
    for name, q, qd in zip(("start_velocity", "end_velocity"), path[[0, -1]], ends, strict=True):
        beyond = positions.beyond_of(farthest_of((q + braking_distances(qd, limits))[None], np.zeros(1))) if qd.any() else None
        if beyond is not None:
            speed = f"{qd[beyond.column]:.4g} of {names[beyond.column]} at {q[beyond.column]:.6g}"
            raise InputError(
                name, f"{speed}: however hard it brakes within its limits, it stops {beyond.text(names)}; give a slower one"
            )
    return ends


def _as_velocity(name: str, given: ArrayLike | None, limits: Limits, names: Sequence[str]) -> Array:
    if given is None:
        return np.zeros(len(names))
    velocity = as_floats(name, given)
    if velocity.shape != (len(names),) or not np.isfinite(velocity).all():
        raise InputError(name, f"{given!r}; {len(names)} finite numbers [rad/s or m/s] are expected")
    over = np.flatnonzero(np.abs(velocity) > limits.velocity * _ABOVE)
    if len(over):
        raise InputError(name, f"{velocity[over[0]]:.4g} of {names[over[0]]}, whose limit is {limits.velocity[over[0]]:.4g}")
    return velocity.copy()


def refuse_path_beyond(argument: str, path: Array, positions: PositionLimits, names: Sequence[str]) -> None:
    """Raise an error if a path, shape (n, n_dof), exceeds position limits; a motion with roundings stays within its hull."""
    beyond = positions.beyond_of(farthest_of(path, np.arange(float(len(path)))))
    if beyond is not None:
        if argument == "q_path":
            raise InputError(argument, f"point {beyond.time:.0f} has {beyond.text(names)}")
        raise InputError(argument, f"the plan has {beyond.text(names)}; plan with robot.with_limits(...) of these limits")


def connect_ends(
    path: Array,
    ends: Ends,
    blend: float,
    limits: Limits,
    certificate: Certificate,
    lengths_of: Callable[[Array], Array],
    names: Sequence[str],
    within: float = math.inf,
) -> TimedPath | JerkLimited:
    """The fastest motion along a path, shape (n, n_dof), with velocities at its ends.

    A velocity may not be along the first or last edge. Then the motion continues straight for the distance that it needs, and
    goes to the second point of the path; all of it is certified. With a finite ``within`` this is not tried.

    lengths_of: a function that measures differences of q. names: the names of the entries of q. Other arguments: see
    ``timed_path``.

    Raises:
        InputError: No such motion is within the limits and free.
    """
    window = 0.0 if limits.jerk is None else 2.0 * float((limits.acceleration / limits.jerk).max())
    speeds = Speeds(*(float(lengths_of(velocity)) for velocity in ends)) if np.any(ends) else AT_REST
    ways, beyond = [0.0, *STRAIGHT_ON] if math.isinf(within) else [0.0], None
    for more in ways:
        first = _straight_entry(path[:2], ends.start, more, limits, window)
        last = _straight_entry(path[-2:][::-1], -ends.end, more, limits, window)
        if first is None or last is None:
            continue
        points = distinct_points(np.vstack([path[:1], *first, path[1:-1], *last, path[-1:]]))
        if len(points) == 1:
            continue
        ahead = [float(lengths_of(each[0] - end)) for each, end in ((first, path[0]), (last, path[-1])) if each]
        lengths, widest = lengths_of(np.diff(points, axis=0)), max(blend, *ahead, 0.0)
        timed = timed_path(points, lengths, widest, limits, certificate, within, speeds)
        if timed is None or speeds == AT_REST:
            if timed is not None:
                return timed
            continue
        leaves = None if certificate.positions is None else certificate.positions.beyond(timed)
        beyond = beyond or leaves
        if leaves is None and (not ahead or is_path_free(certificate, *timed.edges_since(0.0))):
            return timed
    name = "start_velocity" if ends.start.any() else "end_velocity"
    if math.isinf(within):
        reason = (
            "no motion that starts straight, follows the path and ends straight is within the limits and certified "
            "free; give a slower velocity, or another path"
        )
        if beyond is not None:
            reason += f" (one exceeds a limit: {beyond.text(names)})"
    else:
        reason = (
            "it has to be along the first line of the path (for end_velocity the last), and the path has to be long enough to "
            "brake or accelerate within the limits"
        )
    raise InputError(name, reason)


def _straight_entry(edge: Array, velocity: Array, more: float, limits: Limits, window: float) -> list[Array] | None:
    """The end of a straight part before an edge, in a list; empty if the edge is along the velocity.

    edge: its points, shape (2, n_dof), or (1, n_dof) for a path of one point. more: the straight length as a multiple of the
    braking distance. For 0 only the edge itself is tried: None if it is not along the velocity.
    """
    speed = float(np.linalg.norm(velocity))
    if speed == 0.0:
        return []
    along, way = velocity / speed, edge[-1] - edge[0]
    length = float(np.linalg.norm(way))
    is_along = length > 0.0 and np.abs(way / length - along).max() <= _ALONG
    if more == 0.0:
        return [] if is_along else None
    ahead = more * stopping_distance(along, speed, limits.acceleration) + speed * window
    return [] if is_along and length >= ahead else [edge[0] + ahead * along]


def stopping_distance(along: Array, speed: float, acceleration: Array) -> float:
    """The braking distance of a straight motion within limits of acceleration."""
    return 0.5 * speed**2 * float((np.abs(along) / acceleration).max())


def braking_distances(qd: Array, limits: Limits) -> Array:
    """The signed braking distance of each joint [rad or m], from an acceleration of 0.

    With a jerk limit the acceleration ramps up and down symmetrically, so the mean velocity is half the initial one.
    """
    speed = np.abs(qd)
    if limits.jerk is None:
        return 0.5 * qd * speed / limits.acceleration
    reached = speed * limits.jerk >= limits.acceleration**2
    steady = speed / limits.acceleration + limits.acceleration / limits.jerk
    return 0.5 * qd * np.where(reached, steady, 2.0 * np.sqrt(speed / limits.jerk))


def distinct_points(points: Array) -> Array:
    """The points without repetitions of the previous point."""
    return points[np.concatenate([[True], np.abs(np.diff(points, axis=0)).max(axis=1) > 0.0])]
