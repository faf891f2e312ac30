"""Reads the points of a .ply with trimesh."""

import re
from io import BytesIO

import numpy as np
import trimesh
from numpy.typing import NDArray

from ulna.description.file_costs import check_ply
from ulna.errors import count_of


def counts(content: bytes) -> dict[str, int]:
    """The stated count of each element in the header of a .ply file."""
    head = content.partition(b"end_header")[0].decode(errors="replace")
    return {kind: int(count) for kind, count in re.findall(r"^element (\w+) (\d+)", head, re.MULTILINE)}


def _properties(content: bytes) -> list[str]:
    """The names of a vertex's properties in the header of a .ply file."""
    head = content.partition(b"end_header")[0].decode(errors="replace")
    parts = re.split(r"^element +", head, flags=re.MULTILINE)
    vertex = next((part for part in parts if part.startswith("vertex")), "")
    return re.findall(r"^property +(?:list +\w+ +)?\w+ +(\w+)", vertex, re.MULTILINE)


def vertices(content: bytes) -> NDArray[np.float64]:
    """The vertices of a .ply file, shape (n, 3), used by triangles or not."""
    check_ply(content)
    if len(re.findall(rb"^element +vertex ", content.partition(b"end_header")[0], re.MULTILINE)) > 1:
        raise ValueError("it has more than one element vertex; one is read")
    names = _properties(content)
    if any(names.count(axis) != 1 for axis in "xyz"):
        raise ValueError(f"its vertices have the properties {' '.join(names)[:100]}; one x, one y and one z are expected")
    scene = trimesh.load_scene(BytesIO(content), file_type="ply", process=False)
    points = np.concatenate([np.asarray(part.vertices) for part in scene.geometry.values()])
    stated = counts(content).get("vertex", 0)
    if len(points) != stated:
        raise ValueError(f"{len(points)} of its {count_of(stated, 'point')} can be read")
    return points
