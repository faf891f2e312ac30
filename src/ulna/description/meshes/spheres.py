"""Replaces a description's collision meshes by balls that cover them."""

import importlib.metadata
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_count, positive
from ulna.description.meshes import piece_cache
from ulna.description.meshes.hulls import Part, Scale, checked_bytes, mesh_reader, with_shapes
from ulna.description.robot_description import Description
from ulna.description.shapes import Sphere
from ulna.errors import GeometryError

_VERSION = 2  # of the algorithm: a new number invalidates the cache
_WIDER = 1.5  # factor by which ``within`` grows until a budget suffices


def with_balls(description: Description, within: float, most: int | None) -> Description:
    """The description with balls in place of its collision meshes; see ``Robot.with_spheres``."""
    within = positive("within", within, "a distance above 0, in meters,")
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
    """The balls that cover a scaled mesh file: centers and radii [m], shape (n, 4); cached on disk by content."""
    reader, data = mesh_reader(), checked_bytes(path)
    made_by = [_VERSION, importlib.metadata.version("scipy"), path.suffix.lower(), scale, within]
    file = piece_cache.file_name(made_by, data, ".npy")
    found = piece_cache.read(file, piece_cache.balls_from_bytes)
    if found is None:
        from ulna.description.meshes.cover import cover  # noqa: PLC0415 - it imports SciPy

        vertices, faces = reader.merged(reader.read_scene(path, data))
        try:
            found = cover(vertices * scale, faces, within)
        except ValueError as error:
            raise GeometryError(f"within={within:g} is too small for {path.name}: {error}") from None
        piece_cache.write(file, piece_cache.balls_to_bytes(found))
    return found
