"""Defines the shapes of links and of a world's objects, in meters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError, cited, needs_extra
from ulna.kernels.layout import BOX, CAPSULE, CYLINDER, LARGEST, SPHERE


@dataclass(frozen=True, eq=False)
class ConvexMesh:
    """The convex hull of points: a polytope, or a flat polygon if all points lie in a plane.

    A query takes time for every point; ``from_points`` keeps only the hull's vertices.

    Args:
        vertices: Points [m] in the frame of the shape, shape (n, 3), n at least 1. Points inside the hull are allowed.

    Raises:
        InputError: They are not points, empty, not finite, or farther away than a million meters.

    Example:
        >>> ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])
        ConvexMesh(4 vertices)
    """

    vertices: NDArray[np.float64]

    def __init__(self, vertices: ArrayLike) -> None:
        points = np.unique(as_points("vertices", vertices), axis=0)
        points.setflags(write=False)
        object.__setattr__(self, "vertices", points)

    @classmethod
    def from_points(cls, points: ArrayLike) -> ConvexMesh:
        """The hull of points with its vertices alone, found by Qhull.

        For a mesh file: ``ConvexMesh.from_points(trimesh.load_mesh("part.stl").vertices)``.

        Raises:
            InputError: They are not points, or all lie in one plane: use ``ConvexMesh(points)`` for such points.
            MissingExtraError: SciPy, which contains Qhull, is not installed (``ConvexMesh(points)`` does not need it).
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


@dataclass(frozen=True)
class Box:
    """A box centered at its frame's origin. ``extents`` are full edge lengths [m] along x, y, z.

    Raises:
        InputError: The extents are not three finite lengths of at least 0.
    """

    extents: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "extents", lengths("extents", self.extents, 3))

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the edge lengths [m]."""
        return tuple(e / 2 for e in self.extents)  # type: ignore[return-value]


@dataclass(frozen=True)
class Sphere:
    """A sphere about its frame's origin. ``radius`` [m].

    Raises:
        InputError: The radius is not a finite length of at least 0.
    """

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", lengths("radius", (self.radius,), 1)[0])


@dataclass(frozen=True)
class _Round:
    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", lengths("radius", (self.radius,), 1)[0])
        object.__setattr__(self, "length", lengths("length", (self.length,), 1)[0])


class Cylinder(_Round):
    """A cylinder along z, centered at its frame's origin. ``radius`` and ``length`` [m].

    Raises:
        InputError: The radius or the length is not a finite length of at least 0.
    """


class Capsule(_Round):
    """A cylinder along z with a half sphere on each end. ``length`` [m] is the cylinder's, without the ends.

    Raises:
        InputError: The radius or the length is not a finite length of at least 0.
    """


@dataclass(frozen=True)
class Mesh:
    """Triangles from a file. ``uri``: the address in the description; ``scale``: factors along x, y, z."""

    uri: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class HalfSpace:
    """The infinite region below z = 0 of its frame: a floor, or a wall if its frame is turned."""


@dataclass(frozen=True)
class UnknownShape:
    """An unsupported collision shape, which excludes collision checks but not poses; ``kind`` is its name in the description."""

    kind: str


Primitive = Box | Sphere | Cylinder | Capsule
"""Shapes that a few numbers describe."""
Shape = Primitive | Mesh | ConvexMesh | UnknownShape
"""The shapes of links. A description gives meshes as files; ``robot.with_convex_hulls()`` uses their hulls."""
Solid = Primitive | ConvexMesh | HalfSpace
"""The shapes of collision queries."""


class Kind(NamedTuple):
    """The facts about a class of ``Primitive`` that readers, writers, tables of bodies and the page need.

    Attributes:
        shape: The class.
        word: The name in scene files, and of the element in URDF and SDF.
        sizes: The dimensions: of each attribute the count of its numbers [m].
        number: The number in a table of bodies (``kernels.layout``).
        core: The half extents of the core along x, y and z, and the radius of the ball that sweeps it [m].
        urdf: The attributes of the element in URDF, one for each of ``sizes``; none if URDF has no such shape.
        urdf_since: The first version of URDF that has the element.
    """

    shape: type
    word: str
    sizes: Mapping[str, int]
    number: int
    core: Callable[[Any], tuple[float, float, float, float]]
    urdf: tuple[str, ...] = ()
    urdf_since: tuple[int, int] = (1, 0)

    def half_extents(self, shape: object) -> tuple[float, float, float]:
        """Half the edges of the box around a shape of this kind [m]."""
        x, y, z, radius = self.core(shape)
        return x + radius, y + radius, z + radius


KINDS = (
    Kind(Box, "box", {"extents": 3}, BOX, lambda box: (*box.half_extents, 0.0), ("size",)),
    Kind(Sphere, "sphere", {"radius": 1}, SPHERE, lambda ball: (0.0, 0.0, 0.0, ball.radius), ("radius",)),
    Kind(
        Cylinder,
        "cylinder",
        {"radius": 1, "length": 1},
        CYLINDER,
        lambda rod: (rod.radius, rod.radius, rod.length / 2, 0.0),
        ("radius", "length"),
    ),
    Kind(
        Capsule,
        "capsule",
        {"radius": 1, "length": 1},
        CAPSULE,
        lambda rod: (0.0, 0.0, rod.length / 2, rod.radius),
        ("radius", "length"),
        urdf_since=(1, 1),
    ),
)
IN_URDF = {kind.word: kind for kind in KINDS if kind.urdf}


def kind_of(shape: object) -> Kind | None:
    """The kind of a ``Primitive``; None of any other shape."""
    for kind in KINDS:
        if isinstance(shape, kind.shape):
            return kind
    return None


def as_points(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Finite points [m], shape (n, 3), n at least 1."""
    points = within_reach(name, values)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise InputError(name, f"shape {points.shape}; points of shape (n, 3) are expected, at least one")
    return points


def within_reach(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Finite numbers of at most a million meters."""
    numbers = as_floats(name, values)
    if not (np.abs(numbers) <= LARGEST).all():
        raise InputError(name, f"finite numbers of at most {LARGEST:g} m are expected")
    return numbers


def lengths(name: str, values: object, count: int) -> tuple[float, ...]:
    """``count`` finite lengths of at least 0 [m]."""
    given = as_floats(name, values)  # type: ignore[arg-type]
    if given.shape != (count,) or not ((given >= 0) & (given <= LARGEST)).all():
        expected = f"{count} finite length{'s' * (count > 1)} of at least 0 and at most {LARGEST:g} m"
        raise InputError(name, f"{cited(values)}; {expected} {'are' if count > 1 else 'is'} expected")
    return tuple(given.tolist())
