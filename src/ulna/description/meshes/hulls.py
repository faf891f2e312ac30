"""Replaces the collision meshes of a description by their convex hulls."""

import hashlib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from ulna.description.meshes.mesh_files import CHECKED, MeshFiles
from ulna.description.pose import pose
from ulna.description.robot_description import Body, Description, Link
from ulna.description.shapes import ConvexMesh, Mesh, Sphere
from ulna.errors import FileError, InputError, count_of, needs_extra

Scale = tuple[float, float, float]


class Part(NamedTuple):
    """A shape in place of a mesh.

    Attributes:
        shape: The shape.
        excess: Its largest distance beyond the mesh [m]; None if unknown.
        center: The origin of its frame in the frame of the mesh [m].
    """

    shape: ConvexMesh | Sphere
    excess: float | None = None
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)


ShapesOf = Callable[[Path, Scale], tuple[Part, ...]]
_MAX_KEPT = 256  # cached hulls, which robots share
_kept: dict[tuple[bytes, str, Scale], ConvexMesh] = {}
_lock = Lock()


def with_hulls(description: Description) -> Description:
    """The description with convex hulls in place of its collision meshes; its visuals are unchanged."""
    return with_shapes(description, lambda path, scale: (Part(hull_of(path, scale)),))


def with_shapes(description: Description, shapes_of: ShapesOf) -> Description:
    """The description with other shapes in place of each collision mesh, made from its file and scale."""
    files = MeshFiles(description)
    return replace(description, links=tuple(_with_shapes(link, files, shapes_of) for link in description.links))


def n_collision_meshes(description: Description) -> int:
    """The number of collision shapes that are mesh files."""
    return sum(isinstance(body.shape, Mesh) for link in description.links for body in link.collisions)


def in_place_of_meshes(description: Description) -> str:
    """A sentence that names the shapes checked in place of meshes; empty if there are none."""
    covers = [body for link in description.links for body in link.collisions if isinstance(body.shape, Sphere)]
    if excesses := [body.excess for body in covers if body.excess is not None]:
        balls = count_of(len(excesses), "ball that covers", "balls that cover")
        return f"collision by {balls} meshes, and stand{'s' * (len(excesses) == 1)} out by {1000 * max(excesses):.1f} mm at most"
    shapes = [body for link in description.links for body in link.collisions if isinstance(body.shape, ConvexMesh)]
    excesses = [body.excess for body in shapes if body.excess is not None]
    if excesses:
        pieces = count_of(len(excesses), "convex piece of meshes, which stands", "convex pieces of meshes, which stand")
        return f"collision by {pieces} out by {1000 * max(excesses):.1f} mm at most"
    return f"collision by convex hulls of {count_of(len(shapes), 'mesh', 'meshes')}" if shapes else ""


def _with_shapes(link: Link, files: MeshFiles, shapes_of: ShapesOf) -> Link:
    def shaped(body: Body) -> list[Body]:
        if not isinstance(body.shape, Mesh):
            return [body]
        path = files.find(body.shape.uri)
        try:
            parts = shapes_of(path, body.shape.scale)
        except (FileError, InputError) as error:
            message = f"the collision mesh {body.name!r} of link {link.name!r} {error.message}"
            raise FileError(str(path), message) from error
        kind = "ball" if isinstance(parts[0].shape, Sphere) else "piece"
        names = [body.name] if len(parts) == 1 else [f"{body.name} {kind} {k}" for k in range(1, len(parts) + 1)]
        return [
            replace(body, name=name, shape=part.shape, excess=part.excess, pose=body.pose @ pose(part.center))
            for name, part in zip(names, parts, strict=True)
        ]

    return replace(link, collisions=tuple(piece for body in link.collisions for piece in shaped(body)))


def hull_of(path: Path, scale: Scale) -> ConvexMesh:
    """The hull of a mesh file, cached by the file's content. A flat mesh, without volume, keeps all its points."""
    reader, data = mesh_reader(), checked_bytes(path)
    key = hashlib.sha256(data).digest(), path.suffix.lower(), scale
    with _lock:
        found = _kept.pop(key, None)
    if found is None:
        points = reader.used_points(reader.read_scene(path, data)) * scale
        try:
            found = ConvexMesh.from_points(points)
        except InputError:
            found = ConvexMesh(points)
    with _lock:
        _kept[key] = found  # at the end: most recently used
        while len(_kept) > _MAX_KEPT:
            del _kept[next(iter(_kept))]
    return found


def checked_bytes(path: Path) -> bytes:
    """The bytes of a mesh file; raises an error for a format that is drawn but not checked for collisions."""
    if path.suffix.lower() not in CHECKED:
        kinds = ", ".join(CHECKED)
        raise FileError(str(path), f"is of kind {path.suffix.lower()!r}, which is not read for collision checking, only {kinds}")
    return mesh_reader().mesh_bytes(path)


@cache
def mesh_reader():
    """The module ``reader``, imported when first needed, since it imports trimesh."""
    with needs_extra("reading meshes", "hulls", "trimesh", "collada", "scipy"):
        import scipy.spatial  # noqa: F401

        from ulna.description.meshes import reader
    return reader
