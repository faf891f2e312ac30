"""Computes the inertias of shapes and payloads, and detects impossible tensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats, as_number, positive
from ulna.description.robot_description import Inertia
from ulna.description.shapes import Box, Capsule, ConvexMesh, Cylinder, Sphere, within_reach
from ulna.errors import InputError, needs_extra

Array = NDArray[np.float64]
ROUNDING = 1e-3
"""Tolerance of the triangle inequality, relative to the largest moment: published tensors have three digits."""
_ZERO = 1e-9  # relative to the largest entry of a tensor


def tensor_fault(tensor: Array) -> str:
    """The reason why no body has this symmetric tensor about its center of mass; empty if one exists.

    The moments about its principal axes are at least 0, and none is larger than the sum of the others.
    """
    least, middle, most = np.linalg.eigvalsh(tensor).tolist()
    if least < -_ZERO * max(most, 0.0):
        return f"a principal moment is {least:.3g} kg m^2"
    if least + middle < most * (1 - ROUNDING):
        return f"principal moments {least:.3g} + {middle:.3g} < {most:.3g} kg m^2"
    return ""


@dataclass(frozen=True)
class Payload:
    """The mass of an object as the caller gives it; omitted values are None.

    Attributes:
        mass: The mass [kg].
        com: The center of mass in the frame of the object [m], shape (3,).
        inertia: The tensor about the center of mass, in the axes of that frame [kg m^2], shape (3, 3).
        density: The density [kg/m^3], in place of the mass.
    """

    mass: float | None = None
    com: ArrayLike | None = None
    inertia: ArrayLike | None = None
    density: float | None = None

    def of(self, shape: object = None) -> Inertia | None:
        """The inertia in the frame of the object, of uniform density; a point mass without a shape.

        Raises:
            InputError: A number is impossible for a body, or the values do not go together.
            MissingExtraError: It is a convex mesh, and the package that computes its volume is not installed (the extra
                ``hulls``).
        """
        given = {"com": self.com, "inertia": self.inertia}
        if self.density is not None:
            excess = next((name for name, value in {"mass": self.mass, **given}.items() if value is not None), None)
            if excess is not None:
                raise InputError(excess, "is given together with density, which determines it; one of them is expected")
            return _of_density(positive("density", self.density), shape)
        if self.mass is None:
            excess = next((name for name, value in given.items() if value is not None), None)
            if excess is not None:
                raise InputError(excess, "is given without a mass; mass= is expected too")
            return None
        mass = as_number("mass", self.mass, 0.0, "a finite number of kilograms of at least 0")
        is_whole = self.com is not None and self.inertia is not None
        even = _UniformBody() if shape is None or is_whole else _uniform_body(shape)
        com = even.center if self.com is None else _as_point("com", self.com)
        return Inertia(mass, com, mass * even.tensor if self.inertia is None else _as_tensor(self.inertia, mass))


class _UniformBody(NamedTuple):
    """A body of 1 kg and uniform density: its volume [m^3], its center [m], and its tensor about the center."""

    volume: float = 0.0
    center: Array = np.zeros(3)
    tensor: Array = np.zeros((3, 3))


def _of_density(density: float, shape: object) -> Inertia:
    even = _uniform_body(shape)
    if even.volume <= 0.0:
        raise InputError("density", f"{shape!r} has no volume; give its mass")
    mass = density * even.volume
    return Inertia(mass, even.center, mass * even.tensor)


def _uniform_body(shape: object) -> _UniformBody:
    """A shape of 1 kg. Source: tables of moments of inertia; a capsule by the parallel axis theorem."""
    match shape:
        case Box(extents=(x, y, z)):
            return _UniformBody(x * y * z, tensor=np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) / 12)
        case Sphere(radius=r):
            return _UniformBody(4 / 3 * np.pi * r**3, tensor=0.4 * r * r * np.eye(3))
        case Cylinder(radius=r, length=h):
            across = (3 * r * r + h * h) / 12
            return _UniformBody(np.pi * r * r * h, tensor=np.diag([across, across, r * r / 2]))
        case Capsule(radius=r, length=h):
            middle, ends = h, 4 / 3 * r  # volumes over pi r^2
            share = middle / (middle + ends) if middle + ends else 0.0
            across = share * (3 * r * r + h * h) / 12 + (1 - share) * (0.4 * r * r + h * h / 4 + 3 / 8 * h * r)
            along = share * r * r / 2 + (1 - share) * 0.4 * r * r
            return _UniformBody(np.pi * r * r * (middle + ends), tensor=np.diag([across, across, along]))
        case ConvexMesh(vertices=points):
            return _uniform_mesh(points)
    return _UniformBody()


def _uniform_mesh(points: Array) -> _UniformBody:
    """A convex mesh of 1 kg, exact; without volume it is a point at its vertices' mean.

    The hull is divided into tetrahedra, each with a triangle of the hull and a point inside. Source: integrals over a
    tetrahedron, as in Tonon, "Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor in Terms of its Vertex Coordinates",
    2005.
    """
    with needs_extra("the mass of a convex mesh, unless com= and inertia= are given,", "hulls", "scipy"):
        from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415 - of an extra  # pyright: ignore[reportMissingImports]
    inside = points.mean(axis=0)
    try:
        triangles = (points - inside)[ConvexHull(points).simplices]
    except (QhullError, ValueError):  # fewer than four points, or all in one plane
        return _UniformBody(center=inside)
    volumes, sums = np.abs(np.linalg.det(triangles)) / 6, triangles.sum(axis=1)
    shares = volumes / volumes.sum()
    center = shares @ sums / 4
    squares = (np.einsum("t,tki,tkj->ij", shares, triangles, triangles) + np.einsum("t,ti,tj->ij", shares, sums, sums)) / 20
    squares -= np.outer(center, center)
    return _UniformBody(float(volumes.sum()), inside + center, np.trace(squares) * np.eye(3) - squares)


def _as_tensor(inertia: ArrayLike, mass: float) -> Array:
    tensor = as_floats("inertia", inertia)
    if tensor.shape != (3, 3) or not np.isfinite(tensor).all():
        raise InputError("inertia", f"shape {tensor.shape}; finite numbers [kg m^2] of shape (3, 3) are expected")
    if np.abs(tensor - tensor.T).max() > _ZERO * np.abs(tensor).max():
        raise InputError("inertia", "it is not symmetric; its entry (i, j) is that of (j, i), with the sign of URDF")
    tensor = (tensor + tensor.T) / 2
    if fault := tensor_fault(tensor):
        raise InputError("inertia", f"no real body has it: {fault}")
    if not mass and tensor.any():
        raise InputError("inertia", "a body of 0 kg has none; give a mass above 0")
    return tensor


def _as_point(name: str, values: ArrayLike) -> Array:
    point = within_reach(name, values)
    if point.shape != (3,):
        raise InputError(name, f"shape {point.shape}; three numbers [m] are expected")
    return point
