"""Reads obstacles from an uploaded file: the convex hull or the convex pieces of a mesh, or a point cloud."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from ulna.collision.cloud_file import READERS, points_of
from ulna.collision.clouds import PointCloud
from ulna.collision.grids import Obstacle
from ulna.description.meshes import ply
from ulna.description.meshes.decompose import pieces_of_file
from ulna.description.meshes.hulls import hull_of
from ulna.description.meshes.mesh_files import CHECKED
from ulna.description.meshes.reader import MAX_BYTES
from ulna.description.shapes import ConvexMesh
from ulna.errors import FileError

MAX_POINTS = 300_000  # of a point cloud that a browser draws, and that a scene file holds
RADIUS = 0.01  # [m] of the points of a new point cloud


def shapes_of_file(
    name: str, content: bytes, *, scale: float = 1.0, pieces: bool = False, announce: Callable[[str], object] = lambda _: None
) -> tuple[Obstacle, ...]:
    """The shapes of a file, in the frame of the file: one, or the convex pieces of a mesh.

    Args:
        name: The name of the file; its ending gives the format.
        content: The bytes of the file.
        scale: The unit of the file [m].
        pieces: Whether to decompose a mesh into convex pieces, in seconds to minutes. Otherwise its convex hull is taken.
        announce: Called with a message before a decomposition.
    """
    ending = Path(name).suffix.lower()
    if len(content) > MAX_BYTES:
        raise FileError(name, f"is larger than {MAX_BYTES // 1_000_000} MB, the maximum")
    if ending in CHECKED:
        return _mesh(name, content, scale, announce if pieces else None)
    if ending not in READERS:
        raise FileError(name, f"ends in none of {', '.join(ENDINGS)}")
    points = points_of(name, content, scale)
    if ending == ".ply" and ply.counts(content).get("face", 0):
        return (ConvexMesh.from_points(points),)
    if len(points) > MAX_POINTS:
        words = f"has {len(points)} points; the page takes at most {MAX_POINTS}: PointCloud.thinned reduces their number"
        raise FileError(name, words)
    return (PointCloud(points, RADIUS),)


def _mesh(name: str, content: bytes, scale: float, announce: Callable[[str], object] | None) -> tuple[ConvexMesh, ...]:
    """The convex hull of a mesh, or its convex pieces if ``announce`` is given."""
    with TemporaryDirectory(prefix="ulna-") as folder:
        path = Path(folder, f"mesh{Path(name).suffix.lower()}")
        path.write_bytes(content)
        try:
            if announce is None:
                return (hull_of(path, (scale, scale, scale)),)
            return tuple(ConvexMesh(points * scale) for points in pieces_of_file(path, announce).points)
        except FileError as error:
            raise FileError(name, error.message) from None


ENDINGS = (*CHECKED, *READERS)
