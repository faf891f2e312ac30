"""Rounds the corners of a path by parabolas.

A corner P between the unit directions d and e is cut b before and b behind it. The parabola with the control points P - b d, P,
P + b e has the derivative (1 - s / 2b) d + (s / 2b) e by the length s of the path's edges, so that it goes on smoothly from one
edge into the next; its second derivative is (e - d) / 2b.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.ik.time_limit import TimeLimit
from ulna.planning.path_limits import PathLimit, Timed, are_kept
from ulna.planning.positions import Farthest, PositionLimits

Array = NDArray[np.float64]
CHORDS = 4  # along which a parabola is certified
CHORDS_ALONG = 16  # with constraints: of a tight tolerance, what may lie beside a chord takes much; it falls with the square
_HALVINGS = 3  # how often a rounding that is not free is halved; then the motion stops at the corner
_MAX_SHARE = 0.49995  # of an edge: what is left between two roundings is not so short that rounding errors matter in its times
_STRAIGHT = 1e-12  # of the directions of two edges: no corner
_AT_ONCE = 64  # corners that are certified by one call


class IsFree(NamedTuple):
    """What certifies paths."""

    n_free: Callable[[Array, Array], int]
    """How many of some paths, points of shape (m, n, n_dof), are free from the first on, with all that is within spreads, shape
    (m, n - 1, n_dof), of their edges in each entry of q."""
    chords: int = CHORDS
    """Along how many it certifies a rounding."""
    tolerance: float = np.inf
    """The least one of what is kept [m or rad]."""
    positions: PositionLimits | None = None
    """What whole motions are certified to keep. A path between configurations within these limits, and its roundings, are within
    them: the limits are a box, which is convex."""
    caps: tuple[PathLimit, ...] = ()
    """Limits beside those of joints, as of the speed of a hand, which a whole motion must keep."""
    limit: TimeLimit = TimeLimit(None)
    """The time that a motion may take to compute."""


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
    chords: int
    """As of ``IsFree``."""


class Beside(NamedTuple):
    """How far a motion may leave the path about a corner."""

    by: float
    """In each entry of q [rad or m]."""
    reach: float
    """The length of each edge, from the rounding on, along which it may."""


ON_PATH = Beside(0.0, 0.0)


class Edges(NamedTuple):
    """A path and its edges."""

    path: Array
    """Shape (n, n_dof), n >= 2."""
    lengths: Array
    """Above 0, shape (n - 1,)."""
    directions: Array
    """Shape (n - 1, n_dof)."""
    turns: Array
    """How much an entry of the directions changes at most at each point, shape (n,): 0 where it goes straight on."""
    chords: int = CHORDS
    """As of ``IsFree``."""


def edges_of(path: Array, lengths: Array, chords: int = CHORDS) -> Edges:
    """The edges of a path, shape (n, n_dof), which are so long."""
    directions, turns = np.diff(path, axis=0) / lengths[:, None], np.zeros(len(path))
    turns[1:-1] = np.abs(np.diff(directions, axis=0)).max(axis=1)
    return Edges(path, lengths, directions, np.where(turns > _STRAIGHT, turns, 0.0), chords)


def free_cuts(edges: Edges, blend: float, is_free: IsFree, within: float = np.inf, beside: Beside = ON_PATH) -> Array:
    """How much of its two edges the rounding of each point of a path takes, shape (n,): as much as is free, 0 where none is.

    blend: the greatest length of an edge that a rounding takes; within: how far a rounding may leave the path in an entry of
    q. In the middle it does so by b (e - d) / 4. beside: what is free about each rounding too.
    """
    cuts, lengths = np.zeros(len(edges.path)), edges.lengths
    corners = np.flatnonzero(edges.turns) if blend > 0.0 else np.zeros(0, dtype=np.int64)
    most = _MAX_SHARE * np.minimum(lengths[corners - 1], lengths[corners])
    most = np.minimum(np.minimum(blend, most), 4 * within / edges.turns[corners])
    points, spreads = _chords(edges, corners, most, beside)
    halvings, now = 0, 0
    while now < len(corners):
        until = min(now + _AT_ONCE, len(corners))
        n_free = is_free.n_free(points[now:until], spreads[now:until])
        if n_free > 0:
            now, halvings = now + n_free, 0
        if now == until:
            continue
        if halvings == _HALVINGS:
            most[now] = 0.0
            now, halvings = now + 1, 0
        else:
            most[now] *= 0.5
            halvings += 1
            points[now : now + 1], spreads[now : now + 1] = _chords(edges, corners[[now]], most[[now]], beside)
    cuts[corners] = most
    return cuts


def rounded(edges: Edges, cuts: Array) -> Grid:
    """The lines and parabolas of a path with rounded corners; at a corner whose cut is 0 the motion stops."""
    path, lengths, directions, turns, chords = edges
    inner, n = cuts[1:-1], 2 * len(lengths) - 1
    starts, slopes, bends, steps = (np.zeros((n, *each.shape[1:])) for each in (path, path, path, lengths))
    is_cut, stops = np.ones(n, dtype=bool), np.zeros(n, dtype=bool)
    is_cut[1::2] = inner > 0.0
    starts[::2], starts[1::2] = path[:-1] + cuts[:-1, None] * directions, path[1:-1] - inner[:, None] * directions[:-1]
    slopes[::2], slopes[1::2] = directions, directions[:-1]
    bends[1::2] = np.diff(directions, axis=0) / np.where(inner > 0.0, 2 * inner, 1.0)[:, None]
    steps[::2], steps[1::2] = lengths - cuts[:-1] - cuts[1:], 2 * inner
    stops[:-1:2], stops[-1] = (turns[1:-1] > 0.0) & (inner == 0.0), True
    borders = np.concatenate([[0], np.flatnonzero(stops[is_cut]) + 1])
    return Grid(starts[is_cut], slopes[is_cut], bends[is_cut], steps[is_cut], borders, chords)


def is_path_free(is_free: IsFree, points: Array, spreads: Array) -> bool:
    """Whether one path is free: points of shape (n, n_dof), spreads of shape (n - 1, n_dof)."""
    return is_free.n_free(points[None], spreads[None]) > 0


class _Moving(Timed, Protocol):
    """A motion in time."""

    def farthest(self, since: float) -> Farthest: ...

    def edges_since(self, t: float) -> tuple[Array, Array]: ...


def is_motion_free(is_free: IsFree, timed: _Moving, since: float) -> bool:
    """Whether a motion keeps the limits of position and of hands from a time on, and is free: it may leave its path."""
    if is_free.positions is not None and is_free.positions.beyond(timed, since) is not None:
        return False
    return are_kept(timed, is_free.caps, since) and is_path_free(is_free, *timed.edges_since(since))


def end_of(path: Grid) -> Array:
    """Where a path ends, shape (n_dof,)."""
    return path.starts[-1] + path.steps[-1] * (path.slopes[-1] + 0.5 * path.steps[-1] * path.bends[-1])


def _chords(edges: Edges, corners: NDArray[np.int64], cuts: Array, beside: Beside) -> tuple[Array, Array]:
    """The chords of roundings that take so much of their edges, and of the lines about them that the motion may leave.

    Their points, shape (n, k + 1, n_dof), and how far beside each all is to be free, shape (n, k, n_dof).
    """
    corner, b = edges.path[corners, None], cuts[:, None, None]
    before, behind = edges.directions[corners - 1, None], edges.directions[corners, None]
    points = _bernstein(edges.chords) @ np.concatenate([corner - b * before, corner, corner + b * behind], axis=1)
    spread = np.abs(b * (behind - before)) / (4 * edges.chords**2)  # h^2 / 4 of the second difference of the control points
    spreads = np.repeat(spread * (1 + 1e-9), edges.chords, axis=1)
    if beside.reach:
        first, last = (np.minimum(cuts + beside.reach, edges.lengths[k])[:, None, None] for k in (corners - 1, corners))
        points = np.concatenate([corner - first * before, points, corner + last * behind], axis=1)
        spreads = np.concatenate([np.zeros_like(spread), spreads, np.zeros_like(spread)], axis=1) + beside.by
    return points, spreads


@lru_cache(maxsize=4)
def _bernstein(chords: int) -> Array:
    """The weights of the control points at the ends of the chords, shape (chords + 1, 3)."""
    t = np.linspace(0.0, 1.0, chords + 1)
    return np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2], axis=1)
