"""Meshes smooth bodies by surface nets.

A body is a signed distance: a rounded primitive, or a smooth union or difference of bodies.

Sources: S. Gibson, Constrained elastic surface nets (1998); I. Quilez, Distance functions and Smooth minimum (iquilezles.org).
"""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

Vector = NDArray[np.float64]
_MAX_CELLS = 600_000
_BLOCK = 5  # grid points along a side of a block
_STEPS = 4  # of Newton's method, which moves vertices onto the surface


class Distance(NamedTuple):
    """A body as a signed distance, with lengths in m.

    Attributes:
        of: The signed distance of points, shape (n, 3) to (n,); negative inside.
        low, high: The corners of the body's AABB, shape (3,) each.
    """

    of: Callable[[Vector], Vector]
    low: Vector
    high: Vector


def cone(a: Vector, b: Vector, radius_a: float, radius_b: float) -> Distance:
    """A tapered leg with round ends, from a to b."""
    along, radius = b - a, max(radius_a, radius_b)
    square = max(float(along @ along), 1e-18)

    def of(points: Vector) -> Vector:
        share = np.clip((points - a) @ (along / square), 0.0, 1.0)
        return _length(points - a - share[:, None] * along) - radius_a - share * (radius_b - radius_a)

    return Distance(of, np.minimum(a, b) - radius, np.maximum(a, b) + radius)


def drum(place: Vector, axis: Vector, radius: float, half: float, fillet: float) -> Distance:
    """A cylinder about an axis of length 1, with rounded edges."""

    def of(points: Vector) -> Vector:
        height = (points - place) @ axis
        aside = _length(points - place - height[:, None] * axis)
        return _rounded((aside - radius, np.abs(height) - half), fillet)

    reach = half * np.abs(axis) + radius * np.sqrt(np.maximum(1.0 - axis**2, 0.0))
    return Distance(of, place - reach, place + reach)


def box(place: Vector, turn: NDArray[np.float64], half: Vector, fillet: float) -> Distance:
    """A box with rounded edges; the columns of ``turn`` are its axes."""
    fillet, reach = min(fillet, float(half.min())), np.abs(turn) @ half
    return Distance(lambda points: _rounded((np.abs((points - place) @ turn) - half).T, fillet), place - reach, place + reach)


def _length(vectors: Vector) -> Vector:
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))


def _rounded(excess: Iterable[Vector], fillet: float) -> Vector:
    """The distance to a body with rounded edges. excess: coordinates minus half sizes, shape (n,) each."""
    deepest, square = np.float64(-np.inf), np.float64(0.0)
    for one in excess:
        deepest, square = np.maximum(deepest, one + fillet), square + np.maximum(one + fillet, 0.0) ** 2
    return np.minimum(deepest, 0.0) + np.sqrt(square) - fillet


def union(bodies: Sequence[Distance], blend: float) -> Distance:
    """The smooth union of bodies. blend: the size of the fillets between them [m]."""

    def of(points: Vector) -> Vector:
        total = bodies[0].of(points)
        for body in bodies[1:]:
            total = _smooth_minimum(total, body.of(points), blend)
        return total

    low, high = (np.array([getattr(body, end) for body in bodies]) for end in ("low", "high"))
    return Distance(of, low.min(axis=0), high.max(axis=0))


def cut(body: Distance, others: Sequence[Distance], blend: float) -> Distance:
    """The smooth difference of a body and others. blend: the size of the rounding of new edges [m]."""

    def of(points: Vector) -> Vector:
        total = body.of(points)
        for other in others:
            total = -_smooth_minimum(-total, other.of(points), blend)
        return total

    return Distance(of, body.low, body.high)


def _smooth_minimum(a: Vector, b: Vector, blend: float) -> Vector:
    if not blend:
        return np.minimum(a, b)
    near = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.minimum(a, b) - near**2 * blend / 4


def mesh_of(body: Distance, cell: float) -> trimesh.Trimesh | None:
    """Mesh the surface of a body by surface nets; None if the body is empty.

    1. Find the grid points inside. 2. Put a vertex into each cell with corners inside and outside. 3. Connect the vertices
    around each grid edge that the surface crosses to a quadrilateral. 4. Move the vertices to the surface by Newton steps.

    cell: the side of a cell [m]; larger if there would be too many cells.
    """
    extent = body.high - body.low
    cell = max(cell, float(np.prod(extent + 4 * cell) / _MAX_CELLS) ** (1 / 3))
    low = body.low - 2 * cell
    inside = _inside(body, low, np.ceil((extent / cell + 5) / _BLOCK).astype(int), cell)
    n = np.array(inside.shape) - 1
    corners = np.sum([inside[i : n[0] + i, j : n[1] + j, k : n[2] + k] for i, j, k in np.ndindex(2, 2, 2)], axis=0)
    crossed = (corners > 0) & (corners < 8)
    cells = np.argwhere(crossed)
    if not len(cells):
        return None
    number = np.full(crossed.shape, -1)
    number[crossed] = np.arange(len(cells))
    faces = np.concatenate([_quadrilaterals(inside, number, axis) for axis in range(3)])
    points, normals = _on_surface(body, low + cell * (cells + 0.5), faces, cell)
    return trimesh.Trimesh(
        points, np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]), vertex_normals=normals, process=False
    )


def _inside(body: Distance, low: Vector, n_blocks: NDArray[np.int64], cell: float) -> NDArray[np.int8]:
    """Whether each grid point is inside. Only blocks that the surface may cross are evaluated point by point."""
    side = np.arange(_BLOCK)
    within = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1)  # of a block
    firsts = _BLOCK * np.argwhere(np.ones(n_blocks))
    middle = body.of(low + cell * (firsts + (_BLOCK - 1) / 2))
    blocks = np.broadcast_to(middle[:, None] < 0.0, (len(firsts), _BLOCK**3)).copy()
    near = np.abs(middle) <= 1.2 * cell * np.sqrt(3) * (_BLOCK - 1) / 2
    points = low + cell * (firsts[near][:, None] + within.reshape(-1, 3))
    blocks[near] = body.of(points.reshape(-1, 3)).reshape(-1, _BLOCK**3) < 0.0
    grid = blocks.reshape(*n_blocks, _BLOCK, _BLOCK, _BLOCK).transpose(0, 3, 1, 4, 2, 5).reshape(n_blocks * _BLOCK)
    return np.pad(grid[1:-1, 1:-1, 1:-1], 1).astype(np.int8)  # the border is outside, so that the surface is closed


def _on_surface(body: Distance, centers: Vector, faces: NDArray[np.int64], cell: float) -> tuple[Vector, Vector]:
    """Points on the surface near the centers of cells, and their normals, shape (n, 3) each.

    Halfway through the steps each point moves to the mean of its neighbors, for even triangles.
    """
    points, counts = centers.copy(), np.bincount(faces.ravel(), minlength=len(centers))[:, None]
    for k in range(_STEPS):
        if k == _STEPS // 2:
            sides = (points[np.roll(faces, 1, axis=1)] + points[np.roll(faces, -1, axis=1)]).reshape(-1, 3) / 2
            sums = np.stack([np.bincount(faces.ravel(), sides[:, d], len(centers)) for d in range(3)], axis=1)
            points = np.where(counts > 0, sums / np.maximum(counts, 1), points)
        value, slope = _slope(body, points, 0.02 * cell)
        step = value / np.maximum((slope**2).sum(axis=1), 0.25)
        points = np.clip(points - step[:, None] * slope, centers - cell, centers + cell)
    slope = _slope(body, points, 0.2 * cell)[1]
    return points, slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-9)


def _slope(body: Distance, points: Vector, step: float) -> tuple[Vector, Vector]:
    """The distance at points, shape (n,), and its gradient by forward differences, shape (n, 3)."""
    value = body.of(points)
    return value, np.stack([body.of(points + step * e) - value for e in np.eye(3)], axis=1) / step


def _quadrilaterals(inside: NDArray[np.int8], number: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """The quadrilaterals around the grid edges along an axis that the surface crosses, facing outwards, shape (n, 4)."""
    u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
    change = np.diff(inside, axis=axis)
    edges = np.argwhere(change)
    around = np.stack([number[tuple((edges + way).T)] for way in (-u - v, -v, 0 * u, -u)], axis=1)
    outwards = change[tuple(edges.T)] < 0
    return np.where(outwards[:, None], around, around[:, ::-1])
