"""Defines the shapes of links and of a world's objects, in metres."""

from dataclasses import dataclass

from ulna.description.arrays import as_floats
from ulna.description.convex_mesh import ConvexMesh
from ulna.errors import InputError
from ulna.kernels.layout import LARGEST


@dataclass(frozen=True)
class Box:
    """A box centred at its frame's origin. ``extents`` are full edge lengths [m] along x, y, z.

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
    """A cylinder along z, centred at its frame's origin. ``radius`` and ``length`` [m].

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
    """Triangles from a file. ``uri`` is the address as the description gives it; ``scale`` is a factor along x, y, z."""

    uri: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class HalfSpace:
    """All that lies below the plane z = 0 of its frame, without end: a floor, or a wall if its frame is turned."""


Shape = Box | Sphere | Cylinder | Capsule | Mesh | ConvexMesh
"""What a link can have. A description gives meshes as files; ``robot.with_convex_hulls()`` takes their hulls."""
Solid = Box | Sphere | Cylinder | Capsule | ConvexMesh | HalfSpace
"""What a collision query can take."""


def lengths(name: str, values: object, count: int) -> tuple[float, ...]:
    """So many finite lengths of at least 0 [m].

    Raises:
        InputError: They are not; ``name`` is in the message.
    """
    given = as_floats(name, values)  # type: ignore[arg-type]
    if given.shape != (count,) or not ((given >= 0) & (given <= LARGEST)).all():
        expected = f"{count} finite length{'s' * (count > 1)} of at least 0 and at most {LARGEST:g} m"
        raise InputError(name, f"{values!r}; {expected} {'are' if count > 1 else 'is'} expected")
    return tuple(given.tolist())
