"""Reads the points of STL, OBJ and Collada files. Used by ``hulls`` and ``inspection.meshes``."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.pose import matrix_from_quaternion

Array = NDArray[np.float64]
READABLE = (".stl", ".obj", ".dae")
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_DEEPEST = 64  # nodes of a Collada scene within one another


def mesh_points(path: Path) -> Array:
    """The vertices of a mesh in the file's own units (Collada: metres), shape (n, 3), as often as the file names them.

    Collada's ``up_axis`` is passed over, as RViz and Pinocchio do: a description says itself how a mesh is turned.

    Raises:
        ValueError: The file is of another kind, or it has no points, or some that are not finite.
        OSError: It cannot be read.
        etree.XMLSyntaxError: A Collada file is not XML.
    """
    kind = path.suffix.lower()
    if kind not in READABLE:
        raise ValueError(f"a mesh of kind {kind!r} is not read, only {', '.join(READABLE)}")
    points = {".stl": _stl_points, ".obj": _obj_points, ".dae": _collada_points}[kind](path.read_bytes())
    if not len(points):
        raise ValueError("it has no points")
    if not np.isfinite(points).all():
        raise ValueError("it has points that are not finite")
    return points


def _stl_points(data: bytes) -> Array:
    """Binary (a header of 80 bytes, the count, 50 bytes a triangle) where the length fits, else text."""
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + _TRIANGLE.itemsize * count:
        return np.frombuffer(data, _TRIANGLE, offset=84)["corners"].reshape(-1, 3).astype(np.float64)
    return _rows_behind(rb"vertex", data)


def _obj_points(data: bytes) -> Array:
    return _rows_behind(rb"^v", data)


def _rows_behind(word: bytes, data: bytes) -> Array:
    rows = re.findall(rb"%s[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)" % word, data, flags=re.MULTILINE)
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _collada_points(data: bytes) -> Array:
    """The points of all geometries where the scene puts them. Source: Collada 1.4.1 specification, chapter 5."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True)
    root = etree.fromstring(data, parser)
    unit = root.find("{*}asset/{*}unit")
    metres = float(unit.get("meter", "1")) if unit is not None else 1.0
    geometries = {g.get("id"): _positions(g) for g in root.iterfind("{*}library_geometries/{*}geometry")}
    nodes = {node.get("id"): node for node in root.iter("{*}node")}
    clouds = [
        points @ T[:3, :3].T + T[:3, 3]
        for scene in root.iterfind("{*}library_visual_scenes/{*}visual_scene")
        for node in scene.iterfind("{*}node")
        for points, T in _placed(node, np.eye(4), geometries, nodes, 0)
    ]
    return metres * np.concatenate([np.empty((0, 3)), *clouds])


def _positions(geometry: etree._Element) -> Array:
    source = geometry.find("{*}mesh/{*}vertices/{*}input[@semantic='POSITION']")
    arrays = {s.get("id"): s.find("{*}float_array") for s in geometry.iterfind("{*}mesh/{*}source")}
    array = None if source is None else arrays.get(source.get("source", "").lstrip("#"))
    text = "" if array is None or array.text is None else array.text
    return np.array(text.split(), dtype=np.float64).reshape(-1, 3)


def _placed(node: etree._Element, T: Array, geometries: dict, nodes: dict, depth: int) -> Iterator[tuple[Array, Array]]:
    """The geometries of a node and of those below it, with their poses in the scene."""
    if depth > _DEEPEST:
        raise ValueError("its scene is nested too deep")
    T = T @ _transform(node)
    for instance in node.iterfind("{*}instance_geometry"):
        yield geometries.get(instance.get("url", "").lstrip("#"), np.empty((0, 3))), T
    for instance in node.iterfind("{*}instance_node"):
        target = nodes.get(instance.get("url", "").lstrip("#"))
        if target is not None:
            yield from _placed(target, T, geometries, nodes, depth + 1)
    for child in node.iterfind("{*}node"):
        yield from _placed(child, T, geometries, nodes, depth + 1)


def _transform(node: etree._Element) -> Array:
    """The product of a node's matrices, translations, rotations and scales, in their order."""
    T = np.eye(4)
    for element in node.iterchildren(etree.Element):
        tag = etree.QName(element).localname
        if tag not in ("matrix", "translate", "rotate", "scale"):
            continue
        values, step = np.array((element.text or "").split(), dtype=np.float64), np.eye(4)
        if tag == "matrix":
            step = values.reshape(4, 4)
        elif tag == "translate":
            step[:3, 3] = values
        elif tag == "scale":
            step[:3, :3] = np.diag(values)
        elif values[:3].any():
            half, axis = np.radians(values[3]) / 2, values[:3] / np.linalg.norm(values[:3])
            step[:3, :3] = matrix_from_quaternion([np.cos(half), *(np.sin(half) * axis)])
        T = T @ step
    return T
