"""Decomposes a mesh with CoACD, as the program of a child process.

Arrays are passed through pipes, as NumPy's files. The process confines itself before it reads the mesh.
"""

import io
import json
import os
import sys

import numpy as np
from numpy.typing import NDArray

from ulna.description.meshes.kept_pieces import Pieces, from_bytes, to_bytes
from ulna.description.meshes.pieces import pieces_of, sampled_excess
from ulna.description.xacro.child.confinement import confine


def main() -> None:
    """Read a mesh, decompose it, write the pieces."""
    os.environ["OMP_NUM_THREADS"] = "1"  # a confined process cannot start threads
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the library prints to standard output
    import coacd  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    coacd.set_log_level("off")
    cube = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
    sides = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)], dtype=np.int64)
    sides = np.concatenate([sides, [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]])
    for some in (sides, sides[1:]):  # loads libraries, and starts the threads that repair open meshes: not possible later
        from_bytes(to_bytes(_decomposed(coacd, cube, some, {"threshold": 1.0, "preprocess_resolution": 10, "resolution": 100})))
    limits = json.loads(sys.argv[-1])
    confine(limits["memory"], limits["seconds"])
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as request:
        pieces = _decomposed(coacd, request["vertices"], request["faces"], json.loads(str(request["parameters"])))
    sink.write(to_bytes(pieces))
    sink.flush()


def _decomposed(coacd, vertices: NDArray[np.float64], faces: NDArray[np.int64], parameters: dict[str, float]) -> Pieces:
    hulls = [points for points, _ in coacd.run_coacd(coacd.Mesh(vertices, faces), **parameters)]
    pieces = pieces_of(vertices, faces, hulls)
    return Pieces(tuple(pieces), sampled_excess(vertices, faces, pieces))
