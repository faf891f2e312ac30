"""Covers a mesh and its interior with few balls that exceed it little.

Sources: Ma, Bae and Choi, 3D medial axis point approximation using nearest neighbors and the normal field, 2012 (balls that touch
a surface from within). Chvatal, A greedy heuristic for the set-covering problem, 1979. Aurenhammer, Power diagrams, SIAM J.
Computing 1987.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import ConvexHull, KDTree

from ulna.description.meshes.filled_solid import Array, Faces, FilledSolid
from ulna.description.meshes.pieces import halved

_EDGE = 0.6  # of the allowed excess: the longest edge of an element
_NEAR = 0.2  # of the allowed excess: a surface closer to an inner ball has no inner balls of its own
_MAX_ELEMENTS = 500_000
_AT_ONCE = 1 << 22  # triangles and balls, in one array
_ROUNDING = 1e-9  # of the mesh's size


def cover(vertices: Array, faces: Faces, within: float) -> Array:
    """Balls that together contain a mesh and its interior (``FilledSolid``).

    1. The surface is divided into small triangles. Candidates are the balls that touch it from within, each enlarged by
       ``within``. Every ball within the solid is part of such a ball, so no others are needed, except where the surface has no
       interior.
    2. The candidate that contains the most uncovered triangles is chosen, until none is left. Then superfluous balls are removed.
       A triangle is in a ball if its corners are.
    3. Spheres alone bound an uncovered part of the interior. Its point with the largest min(|x - c|^2 - r^2) is a vertex of the
       balls' power diagram. So as long as a vertex lies inside and in no ball, a ball is added about it.

    Args:
        vertices: The vertices of the mesh, shape (n, 3).
        faces: Its triangles, shape (m, 3).
        within: The largest distance of a point of a ball from the solid, above 0, in the unit of the mesh. No radius exceeds the
            depth of the center (``FilledSolid.depth``) plus this.

    Returns:
        The center and the radius of each, shape (k, 4).
    """
    solid = FilledSolid(vertices, faces)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    slack = _ROUNDING * size
    least = within - 2 * slack  # proofs for smaller balls hold for balls larger by the slack, despite rounding
    elements = [_elements(triangles, _EDGE * within) for triangles in solid.surfaces]
    inner = np.concatenate([_inner_balls(one, size, within) for one in elements])
    radii = [max(0.0, solid.depth(ball[:3]) + least) for ball in inner]
    candidates = np.column_stack([inner[:, :3], radii])
    balls = _choose(np.concatenate(elements), candidates, least)
    while len(voids := _uncovered(balls, solid, slack)):
        added = []
        for point in voids:
            if not any(np.linalg.norm(point - ball[:3]) < ball[3] for ball in added):
                added.append((*point, solid.depth(point) + least))
        balls = np.concatenate([balls, added])
    return balls + (0.0, 0.0, 0.0, slack)  # noqa: RUF005


def _elements(triangles: Array, longest: float) -> Array:
    """The triangles, divided until no edge is longer than ``longest``, shape (n, 3, 3)."""
    done = []
    while len(triangles):
        edges = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        whole = edges.max(axis=1) <= longest
        done.append(triangles[whole])
        if sum(map(len, done)) + len(triangles) > _MAX_ELEMENTS:
            raise ValueError(f"more than {_MAX_ELEMENTS} triangles with edges of at most {longest:.3g} m are needed")
        triangles = halved(triangles[~whole], edges[~whole].argmax(axis=1))
    return np.concatenate(done)


def _inner_balls(elements: Array, size: float, within: float) -> Array:
    """Balls that touch elements from within and contain the center of no other, shape (n, 4).

    They are computed for a few elements first, then for more and more elements far from the existing balls.
    """
    middles = elements.mean(axis=1)
    normals = np.cross(elements[:, 1] - elements[:, 0], elements[:, 2] - elements[:, 0])
    volume = np.einsum("ij,ij->", middles - middles.mean(axis=0), normals)
    inwards = -np.sign(volume) * normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    tree, found, open_ = KDTree(middles), [], np.arange(len(middles))
    for cell in (4 * within, 2 * within, within, within / 2):
        cells = np.floor((middles[open_] - middles.min(axis=0)) / cell)
        some = open_[np.unique(cells, axis=0, return_index=True)[1]]
        found.append(_shrink(tree, middles, inwards, some, size))
        open_ = np.setdiff1d(open_, some)
        for ball in found[-1]:
            open_ = open_[np.linalg.norm(middles[open_] - ball[:3], axis=1) > ball[3] + _NEAR * within]
    return np.concatenate(found)


def _shrink(tree: KDTree, middles: Array, inwards: Array, some: NDArray[np.int64], size: float) -> Array:
    """For some elements, the largest ball that touches each from within and contains none, by iterative shrinking."""
    radii, open_ = np.full(len(some), size), np.arange(len(some))
    for _ in range(30):
        at, towards = middles[some[open_]], inwards[some[open_]]
        distances, nearest = tree.query(at + radii[open_, None] * towards)
        to = middles[nearest] - at
        ahead = np.einsum("ij,ij->i", to, towards)
        smaller = (distances < radii[open_] * (1 - 1e-3)) & (ahead > 0)
        open_ = open_[smaller]
        if not len(open_):
            break
        radii[open_] = (np.einsum("ij,ij->i", to, to)[smaller]) / (2 * ahead[smaller])
    return np.column_stack([middles[some] + radii[:, None] * inwards[some], radii])


def _choose(elements: Array, candidates: Array, within: float) -> Array:
    """Greedy set cover: candidates that together contain all elements, each chosen for the most uncovered ones."""
    points, corners = np.unique(elements.reshape(-1, 3), axis=0, return_inverse=True)
    corners = corners.reshape(-1, 3)
    contents = _contents(candidates, points, corners)
    holders = contents.tocsc()
    gains = np.diff(contents.indptr).astype(np.int64)
    left, balls, insides = np.ones(len(elements), dtype=bool), [], []
    while left.any():
        k = int(gains.argmax())
        if gains[k] > 0:
            ball, inside = candidates[k], contents.indices[contents.indptr[k] : contents.indptr[k + 1]]
        else:  # the surface has no interior here
            ball = np.array([*elements[left.argmax()].mean(axis=0), within])
            inside = np.flatnonzero((np.linalg.norm(points - ball[:3], axis=1) <= ball[3])[corners].all(axis=1))
        gains -= np.bincount(holders[:, inside[left[inside]]].indices, minlength=len(gains))
        left[inside] = False
        balls.append(ball)
        insides.append(inside)
    return _select_needed(np.array(balls), insides, len(elements))


def _contents(balls: Array, points: Array, corners: Faces) -> csr_array:
    """The triangles, three points each, in each ball: 1 if contained, shape (n balls, n triangles)."""
    rows, columns = [], []
    step = max(1, _AT_ONCE // len(corners))
    squares = (points**2).sum(axis=1)
    for k in range(0, len(balls), step):
        centers, radii = balls[k : k + step, :3], balls[k : k + step, 3:]
        inside = squares - 2 * centers @ points.T <= radii**2 - (centers**2).sum(axis=1, keepdims=True)
        ball, triangle = np.nonzero(inside[:, corners[:, 0]] & inside[:, corners[:, 1]] & inside[:, corners[:, 2]])
        rows.append(ball + k)
        columns.append(triangle)
    ones = np.ones(sum(map(len, rows)), dtype=np.int8)
    return csr_array((ones, (np.concatenate(rows), np.concatenate(columns))), shape=(len(balls), len(corners)))


def _select_needed(balls: Array, insides: list[NDArray[np.int64]], n: int) -> Array:
    """The balls without those whose elements, of n, the others contain."""
    times = np.bincount(np.concatenate(insides), minlength=n)
    kept = []
    for k in reversed(range(len(balls))):
        if times[insides[k]].min() > 1:
            times[insides[k]] -= 1
        else:
            kept.append(k)
    return balls[kept[::-1]]


def _uncovered(balls: Array, solid: FilledSolid, slack: float) -> Array:
    """The uncovered vertices of the balls' power diagram that lie in the solid, farthest from the balls first."""
    low, high = (balls[:, :3] - balls[:, 3:]).min(axis=0), (balls[:, :3] + balls[:, 3:]).max(axis=0)
    middle, size = (low + high) / 2, float((high - low).max())
    centers, radii = (balls[:, :3] - middle) / size, balls[:, 3] / size
    corners = 8.0 * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])  # distant balls of radius 0
    sites = np.concatenate([centers, corners])
    lifted = np.column_stack([sites, (sites**2).sum(axis=1) - np.concatenate([radii, np.zeros(8)]) ** 2])
    planes = ConvexHull(lifted).equations
    planes = np.unique(planes[planes[:, 3] < -1e-12], axis=0)
    points = -planes[:, :3] / (2 * planes[:, 3:4])
    points = points[(np.abs(points) <= 0.5).all(axis=1)]
    outside = np.array([(np.linalg.norm(centers - point, axis=1) - radii).min() for point in points])
    order = [k for k in np.argsort(-outside) if outside[k] * size > -slack]
    points = points[order] * size + middle
    return points[[solid.depth(point) > 0 for point in points]] if len(points) else points
