"""Finds the boxes around the shapes of links and around the triangles of mesh files, reading each file once."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ulna.description.meshes.hulls import mesh_reader
from ulna.description.meshes.mesh_files import CHECKED, Located, MeshFiles
from ulna.description.robot_description import Body, Link
from ulna.description.shapes import ConvexMesh, Mesh, Shape, kind_of
from ulna.errors import FileError, MissingExtraError

Array = NDArray[np.float64]
_SIGNS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])


class Boxes:
    """The boxes of the shapes of one description, with the rows low and high, shape (2, 3) [m]."""

    def __init__(self, described: Located) -> None:
        self._files = MeshFiles(described)
        self._known: dict[str, Array] = {}

    def box_of_file(self, uri: str) -> Array:
        """The box around the triangles of a mesh file, before scaling.

        Raises:
            FileError: The file is missing, or cannot be read.
            MissingExtraError: The package that reads meshes is not installed.
        """
        if uri not in self._known:
            reader, path = mesh_reader(), self._files.find(uri)
            points = reader.used_points(reader.read_scene(path, reader.mesh_bytes(path)))
            self._known[uri] = np.array([points.min(axis=0), points.max(axis=0)])
        return self._known[uri]

    def box_of_link(self, link: Link) -> Array | None:
        """The box around the shapes of a link in its axes: visuals and collisions, or whichever can be read."""
        kinds = [self._box_of_bodies(bodies) for bodies in (link.visuals, link.collisions) if bodies]
        return _union([box for box in kinds if box is not None])

    def _box_of_bodies(self, bodies: Iterable[Body]) -> Array | None:
        boxes = []
        for body in bodies:
            box = self._box_of_shape(body.shape)
            if box is None:
                return None
            corners = np.where(_SIGNS, box[1], box[0]) @ body.pose[:3, :3].T + body.pose[:3, 3]
            boxes.append(np.array([corners.min(axis=0), corners.max(axis=0)]))
        return _union(boxes)

    def _box_of_shape(self, shape: Shape) -> Array | None:
        if (kind := kind_of(shape)) is not None:
            half = np.array(kind.half_extents(shape))
            return np.array([-half, half])
        match shape:
            case ConvexMesh(vertices=points):
                return np.array([points.min(axis=0), points.max(axis=0)])
            case Mesh(uri, scale) if uri.lower().endswith(CHECKED):
                try:
                    return np.sort(self.box_of_file(uri) * scale, axis=0)
                except (FileError, MissingExtraError, OSError):
                    return None  # another check reports it
        return None


def _union(boxes: list[Array]) -> Array | None:
    if not boxes:
        return None
    return np.array([np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)])
