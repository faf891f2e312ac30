"""Rounds the corners of a path by parabolas.

A corner P between the unit directions d and e is cut b before and b behind it. The parabola with the control points P - b d, P,
P + b e has the derivative (1 - s / 2b) d + (s / 2b) e by the length s of the path's edges, so that it goes on smoothly from one
edge into the next; its second derivative is (e - d) / 2b.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CHORDS = 4  # along which a parabola is certified
_HALVINGS = 3  # how often a rounding that is not free is halved; then the motion stops at the corner
_MOST = 0.49995  # of an edge: what is left between two roundings is not so short that rounding errors matter in its times
_STRAIGHT = 1e-12  # of the directions of two edges: no corner
IsFree = Callable[[Array, Array], bool]


class Grid(NamedTuple):
    """A path as lines and parabolas: q(s) = start + slope s + bend s^2 / 2 in each interval, 0 <= s <= step."""

    starts: Array
    """Shape (n, n_dof); so are slopes and bends."""
    slopes: Array
    bends: Array
    """0 of a line."""
    steps: Array
    """The lengths of the intervals, shape (n,)."""
    borders: NDArray[np.int64]
    """The ends of intervals at which the motion rests, counted from 0, the start of the path, on."""


class Beside(NamedTuple):
    """How far a motion may leave the path about a corner."""

    by: float
    """In each entry of q [rad or m]."""
    reach: float
    """The length of each edge, from the rounding on, along which it may."""


ON_PATH = Beside(0.0, 0.0)


def free_cuts(
    path: Array, lengths: Array, blend: float, is_free: IsFree, within: float = np.inf, beside: Beside = ON_PATH
) -> Array:
    """How much of its two edges the rounding of each point of a path takes, shape (n,): as much as is free, 0 where none is.

    path: (n, n_dof), n >= 2; lengths: of its edges, above 0; blend: the greatest length of an edge that a rounding takes;
    is_free: whether some chords, and what lies within so much of each in each entry of q, are free; within: how far a rounding
    may leave the path in an entry of q. In the middle it does so by b (e - d) / 4. beside: what is free about each rounding too.
    """
    directions, turns = directions_and_turns(path, lengths)
    cuts = np.zeros(len(path))
    for k in np.flatnonzero(turns).tolist() if blend > 0.0 else ():
        most = min(blend, _MOST * lengths[k - 1], _MOST * lengths[k], 4 * within / turns[k])
        cuts[k] = _cut(path[k], directions[k - 1 : k + 1], lengths[k - 1 : k + 1], most, is_free, beside)
    return cuts


def directions_and_turns(path: Array, lengths: Array) -> tuple[Array, Array]:
    """The directions of a path's edges, shape (n - 1, n_dof), and how much an entry of them changes at most at each point, (n,).

    It is 0 at both ends, and where the path goes straight on.
    """
    directions, turns = np.diff(path, axis=0) / lengths[:, None], np.zeros(len(path))
    turns[1:-1] = np.abs(np.diff(directions, axis=0)).max(axis=1)
    return directions, np.where(turns > _STRAIGHT, turns, 0.0)


def rounded(path: Array, lengths: Array, cuts: Array) -> Grid:
    """The lines and parabolas of a path with rounded corners; at a corner whose cut is 0 the motion stops."""
    directions, turns = directions_and_turns(path, lengths)
    rows: list[tuple[Array, Array, Array, float, bool]] = []
    zero = np.zeros(path.shape[1])
    for k, (direction, length) in enumerate(zip(directions, lengths, strict=True)):
        left = length - cuts[k] - cuts[k + 1]
        last = k == len(directions) - 1
        stops = last or (turns[k + 1] > 0.0 and not cuts[k + 1])
        rows.append((path[k] + cuts[k] * direction, direction, zero, left, stops))
        if cuts[k + 1]:
            bend = (directions[k + 1] - direction) / (2 * cuts[k + 1])
            rows.append((path[k + 1] - cuts[k + 1] * direction, direction, bend, 2 * cuts[k + 1], False))
    starts, slopes, bends, sizes, at_rest = zip(*rows, strict=True)
    borders = np.concatenate([[0], np.flatnonzero(at_rest) + 1])
    return Grid(np.array(starts), np.array(slopes), np.array(bends), np.array(sizes), borders)


def _cut(corner: Array, directions: Array, lengths: Array, most: float, is_free: IsFree, beside: Beside) -> float:
    """The length of a rounding between two edges that is free; 0 if none is."""
    t, (before, behind) = np.linspace(0.0, 1.0, CHORDS + 1)[:, None], directions
    for halving in range(_HALVINGS + 1):
        b = most * 0.5**halving
        points = (1 - t) ** 2 * (corner - b * before) + 2 * t * (1 - t) * corner + t**2 * (corner + b * behind)
        spread = np.abs(b * (behind - before)) / (4 * CHORDS**2)  # h^2 / 4 of the second difference of the control points
        spreads = np.tile(spread * (1 + 1e-9), (CHORDS, 1))
        if beside.reach:
            far = np.minimum(b + beside.reach, lengths)
            points = np.vstack([corner - far[0] * before, points, corner + far[1] * behind])
            spreads = np.vstack([np.zeros_like(spread), spreads, np.zeros_like(spread)]) + beside.by
        if is_free(points, spreads):
            return b
    return 0.0
