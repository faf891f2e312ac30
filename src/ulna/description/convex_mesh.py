"""Defines convex meshes: the convex hull of points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError, needs_extra
from ulna.kernels.layout import LARGEST


@dataclass(frozen=True, eq=False)
class ConvexMesh:
    """The convex hull of points: a polytope, or a flat polygon if all points lie in a plane.

    A query takes time for every point; ``from_points`` keeps only those that the hull needs.

    Args:
        vertices: Points [m] in the frame of the shape, shape (n, 3), n at least 1. Points inside the hull are allowed.

    Raises:
        InputError: They are not points, none, not finite, or farther out than a million metres.

    Example:
        >>> ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])
        ConvexMesh(4 vertices)
    """

    vertices: NDArray[np.float64]

    def __init__(self, vertices: ArrayLike) -> None:
        points = as_floats("vertices", vertices)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise InputError("vertices", f"shape {points.shape}; points of shape (n, 3) are expected, at least one")
        if not (np.abs(points) <= LARGEST).all():
            raise InputError("vertices", f"finite coordinates of at most {LARGEST:g} m are expected")
        points = np.unique(points, axis=0)
        points.setflags(write=False)
        object.__setattr__(self, "vertices", points)

    @classmethod
    def from_points(cls, points: ArrayLike) -> ConvexMesh:
        """The same shape with only the vertices of the hull, found by Qhull.

        For a mesh file: ``ConvexMesh.from_points(trimesh.load_mesh("part.stl").vertices)``.

        Raises:
            InputError: They are not points, or all lie in one plane (``ConvexMesh(points)`` takes these).
            MissingExtraError: SciPy, which brings Qhull, is not installed (``ConvexMesh(points)`` does without).
        """
        mesh = cls(points)
        with needs_extra("the convex hull of points", "hulls", "scipy"):
            from scipy.spatial import ConvexHull, QhullError  # pyright: ignore[reportMissingImports]
        try:
            hull = ConvexHull(mesh.vertices)
        except (QhullError, ValueError) as error:
            reason = "fewer than four, or all in one plane; ConvexMesh(points) takes them as they are"
            raise InputError("points", f"{len(mesh.vertices)} distinct points have no volume: {reason}") from error
        return cls(mesh.vertices[hull.vertices])

    def __reduce__(self):
        return ConvexMesh, (self.vertices,)

    def __repr__(self) -> str:
        return f"ConvexMesh({len(self.vertices)} vertices)"
