"""Shapes: what a link looks like, what it collides as, and what stands in the world. All lengths in metres."""

from dataclasses import dataclass

import numpy as np

from ulna.errors import InputError


@dataclass(frozen=True)
class Box:
    """A box centred at its frame's origin. ``extents`` are full edge lengths [m] along x, y, z."""

    extents: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "extents", _lengths("extents", self.extents, 3))

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the edge lengths [m]."""
        return tuple(e / 2 for e in self.extents)  # type: ignore[return-value]


@dataclass(frozen=True)
class Sphere:
    """A sphere about its frame's origin. ``radius`` [m]."""

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", _lengths("radius", (self.radius,), 1)[0])


@dataclass(frozen=True)
class _Round:
    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", _lengths("radius", (self.radius,), 1)[0])
        object.__setattr__(self, "length", _lengths("length", (self.length,), 1)[0])


class Cylinder(_Round):
    """A cylinder along z, centred at its frame's origin. ``radius`` and ``length`` [m]."""


class Capsule(_Round):
    """A cylinder along z with a half sphere on each end. ``length`` [m] is the cylinder's, without the ends."""


@dataclass(frozen=True)
class Mesh:
    """Triangles from a file. ``uri`` is the address as the description gives it; ``scale`` is a factor along x, y, z."""

    uri: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


Shape = Box | Sphere | Cylinder | Capsule | Mesh


def _lengths(name: str, values: object, count: int) -> tuple[float, ...]:
    try:
        lengths = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(name, f"{values!r} is not {count} numbers") from None
    if lengths.shape != (count,) or not np.isfinite(lengths).all() or (lengths < 0).any():
        raise InputError(name, f"{values!r}; {count} finite length{'s' * (count > 1)} of at least 0 m are expected")
    return tuple(float(v) for v in lengths)
