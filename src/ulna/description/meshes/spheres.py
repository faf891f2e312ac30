"""Replaces a description's collision meshes by balls that cover them."""

import hashlib
import importlib.metadata
import json
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_count, positive
from ulna.description.meshes import kept_pieces
from ulna.description.meshes.hulls import Part, Scale, mesh_reader, refuse_unchecked, with_shapes
from ulna.description.robot_description import Description
from ulna.description.shapes import Sphere
from ulna.errors import GeometryError

_VERSION = 1  # of the algorithm: a new number invalidates the cache
_WIDER = 1.5  # by which ``within`` grows until a budget suffices


def with_balls(description: Description, within: float, most: int | None) -> Description:
    """The description with balls in place of its collision meshes; its other shapes and its visuals are unchanged.

    Args:
        description: The description.
        within: The largest distance [m] of a point of a ball from the mesh and what it encloses, above 0.
        most: The largest number of balls for each mesh; None for any number.

    Raises:
        FileError: A mesh is not there, lies where the description may not lead, or cannot be read.
        GeometryError: More balls are needed, or more triangles than are cut.
        InputError: ``within`` is not such a distance, or ``most`` not a count of at least 1.
        MissingExtraError: The libraries that read meshes are not installed.
    """
    within = positive("within", within, "a distance above 0, in metres,")
    most = None if most is None else as_count("most", most, least=1)
    return with_shapes(description, partial(_parts, within=within, most=most))


def _parts(path: Path, scale: Scale, within: float, most: int | None) -> tuple[Part, ...]:
    balls = balls_of_file(path, scale, within)
    if most is not None and len(balls) > most:
        wider, fewer = within, balls
        while len(fewer) > most:
            wider *= _WIDER
            fewer = balls_of_file(path, scale, wider)
        words = f"{len(balls)} balls are needed to cover {path.name} within {1000 * within:.3g} mm, and most={most}"
        raise GeometryError(f"{words}; within={wider:.3g} takes {len(fewer)}")
    return tuple(Part(Sphere(float(r)), within, (float(x), float(y), float(z))) for x, y, z, r in balls)


def balls_of_file(path: Path, scale: Scale, within: float) -> NDArray[np.float64]:
    """The balls that cover a scaled mesh file: centres and radii [m], shape (n, 4); cached on disk by the file's content.

    Raises:
        FileError: It cannot be read.
        GeometryError: ``within`` is too small for its size.
        MissingExtraError: The libraries that read meshes are not installed.
    """
    reader = mesh_reader()
    refuse_unchecked(path)
    data = reader.mesh_bytes(path)
    made_by = json.dumps([_VERSION, importlib.metadata.version("scipy"), path.suffix.lower(), scale, within])
    file = hashlib.sha256(made_by.encode() + b"\0" + data).hexdigest() + ".npy"
    found = kept_pieces.read_as(file, kept_pieces.balls_from_bytes)
    if found is None:
        from ulna.description.meshes.cover import cover  # noqa: PLC0415 - it imports SciPy

        vertices, faces = reader.merged(reader.read_scene(path, data))
        try:
            found = cover(vertices * scale, faces, within)
        except ValueError as error:
            raise GeometryError(f"within={within:g} is too small for {path.name}: {error}") from None
        kept_pieces.write_bytes(file, kept_pieces.balls_to_bytes(found))
    return found
