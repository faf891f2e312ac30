"""Reads the points of a .ply with trimesh."""

import re
from io import BytesIO

import numpy as np
import trimesh
from numpy.typing import NDArray

from ulna.description.file_costs import check_ply


def counts(content: bytes) -> dict[str, int]:
    """How many of each element the header of a .ply states."""
    head = content.partition(b"end_header")[0].decode(errors="replace")
    return {kind: int(count) for kind, count in re.findall(r"^element (\w+) (\d+)", head, re.MULTILINE)}


def vertices(content: bytes) -> NDArray[np.float64]:
    """The vertices of a .ply, shape (n, 3), whether triangles use them or not."""
    check_ply(content)
    scene = trimesh.load_scene(BytesIO(content), file_type="ply", process=False)
    points = np.concatenate([np.asarray(part.vertices) for part in scene.geometry.values()])
    stated = counts(content).get("vertex", 0)
    if len(points) != stated:
        raise ValueError(f"{len(points)} of its {stated} points can be read")
    return points
