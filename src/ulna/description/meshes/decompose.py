"""Replaces a description's collision meshes by convex pieces, by CoACD.

Source: Wei et al., Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree Search, SIGGRAPH 2022.
"""

import importlib.metadata
import io
import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ulna.description.child_process import child_process, last_words
from ulna.description.meshes import piece_cache
from ulna.description.meshes.hulls import Part, Scale, checked_bytes, mesh_reader, with_shapes
from ulna.description.meshes.piece_cache import Pieces
from ulna.description.robot_description import Description
from ulna.description.shapes import ConvexMesh
from ulna.engine.child_program import program_of
from ulna.errors import FileError, MissingExtraError

TIME_LIMIT_S = 900.0
MEMORY_LIMIT_BYTES = 6 << 30
PARAMETERS = {
    "threshold": 0.05,
    "preprocess_resolution": 30,
    "resolution": 500,
    "mcts_nodes": 10,
    "mcts_iterations": 30,
    "mcts_max_depth": 2,
    "seed": 0,
}
_VERSION = 1  # of the processing of CoACD's pieces: a new number invalidates the cache


def with_pieces(description: Description) -> Description:
    """The description with convex pieces in place of its collision meshes; see ``Robot.with_convex_pieces``."""
    return with_shapes(description, _shapes)


def _shapes(path: Path, scale: Scale) -> tuple[Part, ...]:
    pieces = pieces_of_file(path)
    return tuple(Part(ConvexMesh(points * scale), pieces.excess * max(map(abs, scale))) for points in pieces.points)


def pieces_of_file(path: Path, announce: Callable[[str], object] = lambda _: None) -> Pieces:
    """The pieces of a mesh file in its own units, cached on disk by content; ``announce`` precedes a decomposition."""
    reader = mesh_reader()
    if find_spec("coacd") is None:
        raise MissingExtraError("the decomposition of meshes", "decompose")
    data = checked_bytes(path)
    made_by = [_VERSION, importlib.metadata.version("coacd"), PARAMETERS, path.suffix.lower()]
    file = piece_cache.file_name(made_by, data, ".npz")
    found = piece_cache.read(file, piece_cache.from_bytes)
    if found is None:
        vertices, faces = reader.merged(reader.read_scene(path, data))
        announce(f"decomposing {path.name} ({len(faces)} triangles); it is cached for the next run")
        found = _decomposed(path, vertices, faces)
        piece_cache.write(file, piece_cache.to_bytes(found))
    return found


def _decomposed(path: Path, vertices: np.ndarray, faces: np.ndarray) -> Pieces:
    request = io.BytesIO()
    np.savez(request, vertices=vertices, faces=faces, parameters=json.dumps(PARAMETERS))
    program = program_of("ulna.description.meshes.pieces")
    with child_process(program, MEMORY_LIMIT_BYTES, TIME_LIMIT_S) as (child, late):
        output, errors = child.communicate(request.getvalue())
        try:
            return piece_cache.from_bytes(output)
        except (OSError, ValueError, KeyError):
            limits = f"its limits are {TIME_LIMIT_S:g} s and {MEMORY_LIMIT_BYTES >> 30} GiB"
            words = "no end" if late.is_set() else last_words(child, errors)[:200]
            raise FileError(str(path), f"cannot be decomposed into convex pieces ({words}); {limits}") from None
