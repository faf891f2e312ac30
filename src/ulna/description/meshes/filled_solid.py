"""Computes the solid that a mesh encloses, and the depth of points below its surface."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ulna.description.meshes.pieces import winding_numbers

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


class FilledSolid:
    """The triangles of a mesh, and the volume that its surfaces enclose.

    1. A surface is a set of triangles connected by vertices, with consistent winding (``wound_alike``). Its open edges are
       traversed more often in one direction than in the other. Each group of open edges is closed by triangles from each edge to
       the center of the group.
    2. A closed surface has an integer winding number at every point off it, constant along any path that does not cross it. It
       encloses the points whose number is not zero, and cavities if they are surfaces of their own.

    Attributes:
        surfaces: The triangles of each closed surface, shape (m, 3, 3) each.
    """

    def __init__(self, vertices: Array, faces: Faces) -> None:
        groups = _connected(len(vertices), faces[:, [0, 0]], faces[:, [1, 2]])[faces[:, 0]]
        self.surfaces = [_close_surface(vertices, wound_alike(faces[groups == k])) for k in np.unique(groups)]
        self._bounds = [_bounding_balls(triangles) for triangles in self.surfaces]

    def depth(self, point: Array) -> float:
        """A lower bound on the distance of an interior point from the surface; negative distance from the solid outside.

        The ball of this radius about the point is in the solid. A ball that a surface does not cross has one winding number
        throughout. So if a surface encloses its center, it encloses the ball up to the nearest triangle.
        """
        distances = [_distance(point, *parts) for parts in zip(self.surfaces, self._bounds, strict=True)]
        enclosing = [
            d for d, one in zip(distances, self.surfaces, strict=True) if abs(winding_numbers(one, point[None])[0]) > 0.5
        ]
        return max(enclosing) if enclosing else -min(distances)


def wound_alike(faces: Faces) -> Faces:
    """The faces, shape (n, 3), with consistent winding: faces wound against the majority of their part are reversed.

    Two triangles that alone share an edge traverse it in opposite directions if they are wound alike. A graph with two nodes per
    face, as it is and reversed, connects consistent choices. A part that connects both nodes of a face is one-sided, and stays
    unchanged.
    """
    n = len(faces)
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    _, index, counts = np.unique(np.stack([np.minimum(a, b), np.maximum(a, b)]), axis=1, return_inverse=True, return_counts=True)
    order = np.argsort(index.ravel(), kind="stable")
    pairs = order[counts[index.ravel()[order]] == 2].reshape(-1, 2)
    pairs = pairs[(pairs[:, 0] // 3 != pairs[:, 1] // 3) & (a != b)[pairs[:, 0]]]
    (first, second), up = (pairs // 3).T, a < b
    against = up[pairs[:, 0]] == up[pairs[:, 1]]
    if not against.any():
        return faces
    ends, others = np.concatenate([first, first + n]), np.concatenate([second + n * against, second + n * ~against])
    as_is, turned = _connected(2 * n, ends, others).reshape(2, n)
    part, side = np.minimum(as_is, turned), as_is > turned
    most = 2 * np.bincount(part, side) > np.bincount(part)
    wrong = (side != most[part]) & (as_is != turned)
    return np.where(wrong[:, None], faces[:, ::-1], faces)


def _connected(n: int, ends: Faces, others: Faces) -> Faces:
    """The index of the connected component of each of n vertices; edges lead from ``ends`` to ``others``."""
    ends, others = ends.ravel(), others.ravel()
    return connected_components(coo_array((np.ones(len(ends)), (ends, others)), shape=(n, n)), directed=False)[1]


def _close_surface(vertices: Array, faces: Faces) -> Array:
    """The triangles of a surface and those that close it, shape (m, 3, 3).

    As many open edges lead to a vertex as from it. So triangles from a group of open edges to one point leave no edge open.
    """
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    edges, index = np.unique(np.stack([np.minimum(a, b), np.maximum(a, b)], axis=1), axis=0, return_inverse=True)
    surplus = np.bincount(index.ravel(), np.sign(b - a)).astype(np.int64)
    edges = np.where(surplus[:, None] > 0, edges[:, ::-1], edges)  # the direction that is missing
    missing = np.repeat(edges, np.abs(surplus), axis=0)
    if not len(missing):
        return vertices[faces]
    group = _connected(len(vertices), missing[:, 0], missing[:, 1])[missing[:, 0]]
    group = np.unique(group, return_inverse=True)[1]
    centers = np.array([vertices[missing[group == k, 0]].mean(axis=0) for k in range(group.max() + 1)])[group]
    return np.concatenate([vertices[faces], np.stack([vertices[missing[:, 0]], vertices[missing[:, 1]], centers], axis=1)])


def _bounding_balls(triangles: Array) -> tuple[Array, Array]:
    middles = triangles.mean(axis=1)
    return middles, np.linalg.norm(triangles - middles[:, None], axis=2).max(axis=1)


def _distance(point: Array, triangles: Array, bounds: tuple[Array, Array]) -> float:
    """The distance of a point from the nearest triangle; triangles with too distant bounding balls are skipped."""
    to_middles = np.linalg.norm(bounds[0] - point, axis=1)
    near = triangles[to_middles - bounds[1] <= (to_middles + bounds[1]).min()] - point
    along = np.roll(near, -1, axis=1) - near
    length = np.einsum("ijk,ijk->ij", along, along)
    t = np.clip(-np.einsum("ijk,ijk->ij", near, along) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    least = float(np.linalg.norm(near + t[:, :, None] * along, axis=2).min())
    normal = np.cross(along[:, 0], along[:, 1])
    above = (np.einsum("ijk,ijk->ij", np.cross(near, np.roll(near, -1, axis=1)), normal[:, None]) > 0).all(axis=1)
    if not above.any():
        return least
    normal, near = normal[above], near[above, 0]
    return min(least, float((np.abs(np.einsum("ij,ij->i", near, normal)) / np.linalg.norm(normal, axis=1)).min()))
