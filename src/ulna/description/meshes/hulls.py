"""Replaces the collision meshes of a description by their convex hulls. Used by ``Robot``."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from lxml import etree

from ulna.description.convex_mesh import ConvexMesh
from ulna.description.meshes.files import MeshFiles
from ulna.description.meshes.points import mesh_points
from ulna.description.robot_description import Body, Description, Link
from ulna.description.shapes import Mesh
from ulna.errors import FileError, InputError

_KEPT = 256  # hulls, of files that robots share


def with_hulls(description: Description) -> Description:
    """The description whose collision meshes are their convex hulls; what is seen stays as it is.

    Raises:
        FileError: A mesh is not there, lies where the description may not lead, or cannot be read.
        MissingExtraError: SciPy, which finds hulls, is not installed.
    """
    files = MeshFiles(description)
    return replace(description, links=tuple(_hulled(link, files) for link in description.links))


def _hulled(link: Link, files: MeshFiles) -> Link:
    def hulled(body: Body) -> Body:
        if not isinstance(body.shape, Mesh):
            return body
        path = files.find(body.shape.uri)
        try:
            return replace(body, shape=_hull(path, path.stat().st_mtime_ns, body.shape.scale))
        except (OSError, ValueError, etree.XMLSyntaxError) as error:
            reason = " ".join(str(error).split())[:200]
            raise FileError(str(path), f"the collision mesh {body.name!r} of link {link.name!r} has no hull: {reason}") from error

    return replace(link, collisions=tuple(map(hulled, link.collisions)))


@lru_cache(maxsize=_KEPT)
def _hull(path: Path, _changed: int, scale: tuple[float, float, float]) -> ConvexMesh:
    """The hull of a file as it was at one time. A flat mesh, which has no volume, keeps all its points."""
    points = mesh_points(path) * scale
    try:
        return ConvexMesh.from_points(points)
    except InputError:
        return ConvexMesh(points)
