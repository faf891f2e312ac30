"""Decomposes a mesh into convex pieces in a child process, and measures the excess of their hulls.

CoACD works on a remeshed closed surface, so its pieces are near the mesh but do not contain it. Here each triangle of the mesh is
assigned to one piece, and a piece becomes the hull of its triangles: together they contain the surface. Arrays are passed through
pipes, as NumPy's files. The process confines itself before it reads the mesh.
"""

import io
import json
import os
import sys

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, KDTree, QhullError

from ulna.description.meshes.piece_cache import Pieces, from_bytes, to_bytes
from ulna.description.xacro.child.confinement import confine


def main() -> None:
    """Read a mesh, decompose it, write the pieces."""
    os.environ["OMP_NUM_THREADS"] = "1"  # a confined process cannot start threads
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the library prints to standard output
    import coacd  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    coacd.set_log_level("off")
    cube = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
    sides = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)], dtype=np.int64)
    sides = np.concatenate([sides, [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]])
    for some in (sides, sides[1:]):  # loads libraries, and starts the threads that repair open meshes: not possible later
        from_bytes(to_bytes(_decomposed(coacd, cube, some, {"threshold": 1.0, "preprocess_resolution": 10, "resolution": 100})))
    limits = json.loads(sys.argv[-1])
    confine(limits["memory"], limits["seconds"])
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as request:
        pieces = _decomposed(coacd, request["vertices"], request["faces"], json.loads(str(request["parameters"])))
    sink.write(to_bytes(pieces))
    sink.flush()


def _decomposed(coacd, vertices: NDArray[np.float64], faces: NDArray[np.int64], parameters: dict[str, float]) -> Pieces:
    hulls = [points for points, _ in coacd.run_coacd(coacd.Mesh(vertices, faces), **parameters)]
    pieces = pieces_of(vertices, faces, hulls)
    return Pieces(tuple(pieces), sampled_excess(vertices, faces, pieces))


Array = NDArray[np.float64]
Faces = NDArray[np.int64]
_FINEST = 0.01  # of the mesh's diagonal: smaller triangles are not divided
_OUTSIDE = 1e-3  # of the diagonal: a triangle that protrudes from a piece by less counts as inside
_MAX_TRIANGLES = 500_000
_SURFACE_SAMPLES, _PIECE_SAMPLES = 50_000, 10_000
_AT_ONCE = 1 << 22  # pairs of points and triangles, or of points and planes, in one array


def pieces_of(vertices: Array, faces: Faces, hulls: list[Array]) -> list[Array]:
    """The corners of the hulls of groups of triangles, a group for each given hull, none empty.

    1. A triangle is assigned to the hull from which it protrudes least: by the largest distance of its corners from the planes.
    2. A triangle that protrudes from every hull is divided at the middle of its longest edge, until it is inside one or small.

    Args:
        vertices: The vertices of the mesh, shape (n, 3).
        faces: Its triangles, shape (m, 3).
        hulls: The points of approximate convex pieces, shape (k, 3) each.

    Returns:
        Points, shape (k, 3) each: their hulls together contain every triangle of the mesh.
    """
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    planes = [ConvexHull(points).equations for points in hulls]
    triangles, owners, done = vertices[faces], [], []
    while len(triangles):
        leaves = np.array([_distances_outside(triangles, of_hull) for of_hull in planes])
        edges = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        whole = (leaves.min(axis=0) <= _OUTSIDE * size) | (edges.max(axis=1) <= _FINEST * size)
        if len(triangles) + sum(map(len, done)) > _MAX_TRIANGLES:
            whole[:] = True
        owners.append(leaves.argmin(axis=0)[whole])
        done.append(triangles[whole])
        triangles = halved(triangles[~whole], edges[~whole].argmax(axis=1))
    owner, triangles = np.concatenate(owners), np.concatenate(done)
    groups = [triangles[owner == k].reshape(-1, 3) for k in range(len(hulls))]
    return [_corners(group) for group in groups if len(group)]


def _distances_outside(triangles: Array, planes: Array) -> Array:
    """The distance of each triangle beyond a hull: the maximum over its corners and the hull's planes, shape (m,)."""
    step = max(1, _AT_ONCE // (3 * len(planes)))
    parts = (triangles[k : k + step] @ planes[:, :3].T + planes[:, 3] for k in range(0, len(triangles), step))
    return np.concatenate([part.max(axis=(1, 2)) for part in parts])


def halved(triangles: Array, longest: NDArray[np.int64]) -> Array:
    """Divide each triangle in two, at the middle of the edge that begins at corner ``longest``."""
    rows = np.arange(len(triangles))
    a, b, c = (triangles[rows, (longest + k) % 3] for k in range(3))
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])


def _corners(points: Array) -> Array:
    points = np.unique(points, axis=0)
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # flat
        return points


def sampled_excess(vertices: Array, faces: Faces, pieces: list[Array]) -> float:
    """The excess of pieces over a mesh: the largest distance of their sampled points from the enclosed solid.

    Samples are 10,000 points on the pieces and within them, spread by area, so the true value is slightly larger. A point is
    within the mesh if the winding number exceeds a half (Jacobson et al., Robust Inside-Outside Segmentation, 2013); its distance
    is 0. The distance of another point is measured to the eight triangles around the nearest points of the surface.

    Args:
        vertices: The vertices of the mesh, shape (n, 3).
        faces: Its triangles, shape (m, 3).
        pieces: The corners of convex pieces, shape (k, 3) each.

    Returns:
        The distance [the unit of the mesh].
    """
    random = np.random.default_rng(0)
    triangles = vertices[faces]
    points = _samples_of_pieces(pieces, random)
    surface, owner = _samples_of_triangles(triangles, _SURFACE_SAMPLES, random)
    near = np.asarray(KDTree(surface).query(points, k=8)[1])
    distances = np.full(len(points), np.inf)
    for column in near.T:
        closest = trimesh.triangles.closest_point(triangles[owner[column]], points)
        np.minimum(distances, np.linalg.norm(closest - points, axis=1), out=distances)
    farthest_first = np.argsort(-distances)
    step = max(1, _AT_ONCE // len(triangles))
    for k in range(0, len(points), step):
        some = farthest_first[k : k + step]
        outside = np.abs(winding_numbers(triangles, points[some])) <= 0.5
        if outside.any():
            return float(distances[some[outside.argmax()]])
    return 0.0


def _samples_of_triangles(triangles: Array, n: int, random: np.random.Generator) -> tuple[Array, NDArray[np.int64]]:
    """Points spread over triangles by area, shape (n, 3), and the triangle of each."""
    a, b, c = triangles.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(triangles), n, p=areas / areas.sum())
    u, v = random.random((n, 1)), random.random((n, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen], chosen


def _samples_of_pieces(pieces: list[Array], random: np.random.Generator) -> Array:
    """Points on and in the pieces that have a volume, shape (n, 3): half of them on their surfaces."""
    hulls = []
    for points in pieces:
        try:
            hulls.append((points, ConvexHull(points)))
        except (QhullError, ValueError):
            continue  # flat, within the mesh's own surface
    if not hulls:
        return np.empty((0, 3))
    surface = np.concatenate([points[hull.simplices] for points, hull in hulls])
    middles = np.concatenate([np.repeat(points.mean(axis=0)[None], len(hull.simplices), axis=0) for points, hull in hulls])
    samples, owner = _samples_of_triangles(surface, _PIECE_SAMPLES, random)
    inwards = np.where(np.arange(len(samples)) % 2, 1.0, np.cbrt(random.random(len(samples))))[:, None]
    return middles[owner] + inwards * (samples - middles[owner])


def winding_numbers(triangles: Array, points: Array) -> Array:
    """The winding number of a surface at each point: the solid angles (Van Oosterom and Strackee 1983) over 4 pi."""
    a, b, c = (triangles[None, :, k] - points[:, None] for k in range(3))
    lengths = [np.linalg.norm(one, axis=2) for one in (a, b, c)]
    determinant = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    divisor = lengths[0] * lengths[1] * lengths[2]
    for one, other, length in ((a, b, lengths[2]), (b, c, lengths[0]), (c, a, lengths[1])):
        divisor = divisor + np.einsum("ijk,ijk->ij", one, other) * length
    return np.arctan2(determinant, divisor).sum(axis=1) / (2 * np.pi)
