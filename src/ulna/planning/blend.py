"""Rounds the corners of a path by parabolas.

A corner P between edges with unit directions d and e is cut at the distance b before and after it. The parabola has the control
points P - b d, P and P + b e. Let s be the length along the edges. The first derivative is (1 - s / 2b) d + (s / 2b) e, so it
joins the edges smoothly. Its second derivative is (e - d) / 2b.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.ik.time_limit import TimeLimit
from ulna.planning.path_limits import PathLimit, Timed, within_path_limits
from ulna.planning.positions import Farthest, PositionLimits

Array = NDArray[np.float64]
CHORDS = 4  # chords per parabola for its certificate
CHORDS_ALONG = 16  # with constraints: the distance from a chord, quadratic in its length, uses part of a tight tolerance
_HALVINGS = 3  # maximum halvings of a rounding that is not free; then the motion stops at the corner
_MAX_SHARE = 0.49995  # share of an edge that a rounding may replace, so that times between two roundings are not rounding errors
_STRAIGHT = 1e-12  # a smaller change of direction is no corner
_AT_ONCE = 64  # corners certified by one call


class Certificate(NamedTuple):
    """A certificate of paths and motions."""

    n_free: Callable[[Array, Array], int]
    """A function that counts free paths, from the first to the first that is not free. Its arguments are the points, shape (m, n,
    n_dof), and the distances from the edges in each entry of q to include, shape (m, n - 1, n_dof)."""
    chords: int = CHORDS
    """The number of chords of a rounding."""
    tolerance: float = np.inf
    """The smallest tolerance of the constraints [m or rad]."""
    positions: PositionLimits | None = None
    """Position limits for whole motions. They are a convex box, so a path between configurations within them, with its roundings,
    is within them too."""
    caps: tuple[PathLimit, ...] = ()
    """Limits of hands and torques for whole motions."""
    limit: TimeLimit = TimeLimit(None)
    """The maximum computation time of a motion."""


class Grid(NamedTuple):
    """A path of lines and parabolas.

    In each interval q(s) = start + slope s + bend s^2 / 2, with 0 <= s <= step.
    """

    starts: Array
    """Positions at the starts of the intervals, shape (n, n_dof)."""
    slopes: Array
    """First derivatives at the starts, shape (n, n_dof)."""
    bends: Array
    """Second derivatives, shape (n, n_dof); 0 for a line."""
    steps: Array
    """The lengths of the intervals, shape (n,)."""
    borders: NDArray[np.int64]
    """The indices of the grid points at which the motion rests; grid point 0 is the start of the path."""
    chords: int
    """The number of chords of a rounding; see ``Certificate``."""


class Deviation(NamedTuple):
    """The deviation of a motion from the path near a corner, which the corner's certificate includes."""

    by: float
    """The largest deviation in each entry of q [rad or m]."""
    reach: float
    """The length of each edge, from the rounding, on which the motion may deviate."""


ON_PATH = Deviation(0.0, 0.0)


class Edges(NamedTuple):
    """A path with its edges."""

    path: Array
    """The points, shape (n, n_dof), n >= 2."""
    lengths: Array
    """The lengths of the edges, above 0, shape (n - 1,)."""
    directions: Array
    """The directions of the edges, shape (n - 1, n_dof)."""
    turns: Array
    """The largest change of an entry of the direction at each point, shape (n,): 0 where the path is straight."""
    chords: int = CHORDS
    """The number of chords of a rounding; see ``Certificate``."""


def edges_of(path: Array, lengths: Array, chords: int = CHORDS) -> Edges:
    """The edges of a path, shape (n, n_dof), with given lengths, shape (n - 1,)."""
    directions, turns = np.diff(path, axis=0) / lengths[:, None], np.zeros(len(path))
    turns[1:-1] = np.abs(np.diff(directions, axis=0)).max(axis=1)
    return Edges(path, lengths, directions, np.where(turns > _STRAIGHT, turns, 0.0), chords)


def find_free_cuts(
    edges: Edges, blend: float, certificate: Certificate, within: float = np.inf, deviation: Deviation = ON_PATH
) -> Array:
    """The largest free rounding of each point of a path: the length cut off both edges, shape (n,).

    It is 0 if no rounding is free. blend: the largest length to cut off. within: the largest distance of a rounding from the
    corner in an entry of q; in the middle it is b (e - d) / 4. deviation: the deviation near each rounding that must be free too.
    """
    cuts, lengths = np.zeros(len(edges.path)), edges.lengths
    corners = np.flatnonzero(edges.turns) if blend > 0.0 else np.zeros(0, dtype=np.int64)
    most = _MAX_SHARE * np.minimum(lengths[corners - 1], lengths[corners])
    most = np.minimum(np.minimum(blend, most), 4 * within / edges.turns[corners])
    points, spreads = _chords(edges, corners, most, deviation)
    halvings, now = 0, 0
    while now < len(corners):
        until = min(now + _AT_ONCE, len(corners))
        n_free = certificate.n_free(points[now:until], spreads[now:until])
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
            points[now : now + 1], spreads[now : now + 1] = _chords(edges, corners[[now]], most[[now]], deviation)
    cuts[corners] = most
    return cuts


def round_corners(edges: Edges, cuts: Array) -> Grid:
    """The lines and parabolas of a path with rounded corners; the motion stops at a corner with cut 0."""
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


def is_path_free(certificate: Certificate, points: Array, spreads: Array) -> bool:
    """Whether one path is free, from its points, shape (n, n_dof), and spreads, shape (n - 1, n_dof)."""
    return certificate.n_free(points[None], spreads[None]) > 0


class _Moving(Timed, Protocol):
    """The interface of a motion in time."""

    def farthest(self, since: float) -> Farthest: ...

    def edges_since(self, t: float) -> tuple[Array, Array]: ...


def is_motion_free(certificate: Certificate, timed: _Moving, since: float) -> bool:
    """Whether a motion, from a time on, is free and within the limits of positions, hands and torques."""
    if certificate.positions is not None and certificate.positions.beyond(timed, since) is not None:
        return False
    return within_path_limits(timed, certificate.caps, since) and is_path_free(certificate, *timed.edges_since(since))


def end_of(path: Grid) -> Array:
    """The end of a path, shape (n_dof,)."""
    return path.starts[-1] + path.steps[-1] * (path.slopes[-1] + 0.5 * path.steps[-1] * path.bends[-1])


def _chords(edges: Edges, corners: NDArray[np.int64], cuts: Array, deviation: Deviation) -> tuple[Array, Array]:
    """The chords of roundings with given cuts, and of the adjacent lines from which the motion may deviate.

    Returns:
        The points, shape (n, k + 1, n_dof), and the distance from each chord that must be free, shape (n, k, n_dof).
    """
    corner, b = edges.path[corners, None], cuts[:, None, None]
    before, behind = edges.directions[corners - 1, None], edges.directions[corners, None]
    points = _bernstein(edges.chords) @ np.concatenate([corner - b * before, corner, corner + b * behind], axis=1)
    spread = np.abs(b * (behind - before)) / (4 * edges.chords**2)  # h^2 / 4 of the second difference of the control points
    spreads = np.repeat(spread * (1 + 1e-9), edges.chords, axis=1)
    if deviation.reach:
        first, last = (np.minimum(cuts + deviation.reach, edges.lengths[k])[:, None, None] for k in (corners - 1, corners))
        points = np.concatenate([corner - first * before, points, corner + last * behind], axis=1)
        spreads = np.concatenate([np.zeros_like(spread), spreads, np.zeros_like(spread)], axis=1) + deviation.by
    return points, spreads


@lru_cache(maxsize=4)
def _bernstein(chords: int) -> Array:
    """The weights of the control points at the ends of the chords, shape (chords + 1, 3)."""
    t = np.linspace(0.0, 1.0, chords + 1)
    return np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2], axis=1)
