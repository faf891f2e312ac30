"""Names the parts of convex bodies for the distance kernels."""

from typing import Any, NamedTuple

from numpy.typing import NDArray


class Core(NamedTuple):
    """A convex shape in its own frame.

    Kind and vertices are the same in all lanes; the half extents are numbers of lanes.
    """

    kind: int
    """A kind of ``kernels.layout``."""
    half: Any
    """Three half extents [m]."""
    vertices: NDArray
    """Vertices of a hull, shape (n, 3); else of shape (0, 3)."""


class Body(NamedTuple):
    """A core at a pose, swept by a ball."""

    pose: Any
    """Twelve numbers."""
    core: Core
    radius: Any
    """Radius of the ball [m]."""


class Simplex(NamedTuple):
    """Up to three points of the Minkowski difference of two cores, and their convex hull's point nearest to the origin."""

    v: Any
    """The nearest point."""
    points: Any
    """Three points."""
    sources: Any
    """The points of the first core that belong to these."""
    weights: Any
    """The weights of the three points in v."""
