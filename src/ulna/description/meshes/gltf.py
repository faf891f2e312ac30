"""Checks a glTF or GLB file before allocating arrays: compares the sizes in its JSON with its data.

Source: Khronos, glTF 2.0 specification, chapters 3.5 to 3.7 and 4.
"""

from typing import Any

from ulna.description.file_bytes import json_value
from ulna.description.meshes.mesh_files import MAX_TRIANGLES
from ulna.errors import cited, count_of

_MAX_JSON = 20_000_000  # bytes
_MAX_BUFFERS = 100_000_000  # bytes of all buffers
_MAX_ITEMS = {"nodes": 10_000, "meshes": 10_000, "accessors": 50_000, "bufferViews": 50_000, "buffers": 16, "images": 64}
_MAX_DEPTH = 64  # nested nodes
_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # by componentType
_NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}  # by type
_TWICE = 2  # two accessors may read the same bytes, as in a mesh with two morphs; more are refused


def check_gltf(kind: str, data: bytes) -> None:
    """Raise ValueError if a file states more than it contains, or exceeds the limits.

    Args:
        kind: ``.glb`` or ``.gltf``.
        data: The file.
    """
    text = _json_chunk(data) if kind == ".glb" else data
    if len(text) > _MAX_JSON:
        raise ValueError(f"its JSON has {len(text)} bytes; up to {_MAX_JSON} are read")
    tree = json_value(text)
    if not isinstance(tree, dict):
        raise ValueError("its JSON is not an object")  # noqa: TRY004 - of a file
    for key, most in _MAX_ITEMS.items():
        if len(_items(tree, key)) > most:
            raise ValueError(f"it has {len(tree[key])} {key}; up to {most} are read")
    _check_arrays(tree)
    _check_nodes(tree, _check_meshes(tree))


def _json_chunk(data: bytes) -> bytes:
    length = int.from_bytes(data[12:16], "little")
    if data[:4] != b"glTF" or data[16:20] != b"JSON" or 20 + length > len(data):
        raise ValueError("it is not a GLB file that begins with the JSON that its header states")
    return data[20 : 20 + length]


def _check_arrays(tree: dict[str, Any]) -> None:
    """Check that views lie within buffers and accessors within views, and that no bytes are read many times."""
    buffers = [_whole(one, "byteLength") for one in _items(tree, "buffers")]
    if sum(buffers) > _MAX_BUFFERS:
        raise ValueError(f"its buffers have {sum(buffers)} bytes; up to {_MAX_BUFFERS} are read")
    views, read = _items(tree, "bufferViews"), 0
    for view in views:
        _within(_whole(view, "byteOffset", 0) + _whole(view, "byteLength"), _at(buffers, view["buffer"]), "a view", "its buffer")
    if sum(_whole(view, "byteLength") for view in views) > _TWICE * sum(buffers):
        raise ValueError("its views read the bytes of its buffers many times")
    for one in _items(tree, "accessors"):
        count, each = _whole(one, "count"), _BYTES[one["componentType"]] * _NUMBERS[one["type"]]
        read += count * each
        if "bufferView" in one:
            view = _at(views, one["bufferView"])
            step = _whole(view, "byteStride", each) or each
            last = _whole(one, "byteOffset", 0) + (count - 1) * step + each if count else 0
            _within(last, _whole(view, "byteLength"), "an accessor", "its view")
        elif count:
            entries = count_of(count, "entry", "entries")
            raise ValueError(f"an accessor of {entries} has no view: it is all zeros, or compressed, which is not read")
    if read > _TWICE * sum(buffers):
        raise ValueError("its accessors read the bytes of its buffers many times")


def _check_meshes(tree: dict[str, Any]) -> list[int]:
    """An upper bound on the triangles of each mesh; limits the points that its primitives copy."""
    accessors, n_points, triangles = _items(tree, "accessors"), 0, []
    for mesh in _items(tree, "meshes"):
        n = 0
        for primitive in _items(mesh, "primitives"):
            attributes = primitive["attributes"].values()
            counts = [_whole(_at(accessors, index), "count") for index in attributes] or [0]
            n_points += sum(counts)
            corners = _whole(_at(accessors, primitive["indices"]), "count") if "indices" in primitive else counts[0]
            n += corners if primitive.get("mode", 4) == 5 else corners // 3  # 5: a strip
        triangles.append(n)
    if n_points > 6 * MAX_TRIANGLES:
        raise ValueError(f"its primitives have {n_points} points and normals; up to {6 * MAX_TRIANGLES} are read")
    if sum(triangles) > MAX_TRIANGLES:
        raise ValueError(f"its meshes have {sum(triangles)} triangles; up to {MAX_TRIANGLES} are read")
    return triangles


def _check_nodes(tree: dict[str, Any], triangles: list[int]) -> None:
    """Check that nodes form trees, as the specification requires: each has at most one parent, without cycles."""
    nodes, parents, shown = _items(tree, "nodes"), {}, 0
    for k, node in enumerate(nodes):
        for child in _items(node, "children"):
            if not isinstance(child, int) or not 0 <= child < len(nodes) or child in parents:
                raise ValueError("its nodes are not a tree: one is missing, or within two others")
            parents[child] = k
        shown += _at(triangles, node["mesh"]) if "mesh" in node else 0
    for k in range(len(nodes)):
        node, depth = k, 0
        while node in parents:
            node, depth = parents[node], depth + 1
            if depth > _MAX_DEPTH:
                raise ValueError(f"its nodes are more than {_MAX_DEPTH} deep, or one is within itself")
    if shown > MAX_TRIANGLES:
        raise ValueError(f"its scene has {shown} triangles; up to {MAX_TRIANGLES} are read")


def _items(tree: dict[str, Any], key: str) -> list[Any]:
    found = tree.get(key, [])
    if not isinstance(found, list):
        raise ValueError(f"its {key} are not a list")  # noqa: TRY004 - of a file
    return found


def _at(items: list[Any], index: Any) -> Any:
    if not isinstance(index, int) or not 0 <= index < len(items):
        raise ValueError("it refers to an item that it does not have")
    return items[index]


def _whole(item: dict[str, Any], key: str, default: int | None = None) -> int:
    value = item.get(key, default)
    if not isinstance(value, int) or not 0 <= value < 1 << 40:
        raise ValueError(f"its {key} is {cited(value):.60}; a whole number of at least 0 is expected")
    return value


def _within(end: int, length: int, what: str, whole: str) -> None:
    if end > length:
        raise ValueError(f"{what} ends at byte {end} of {whole}, which has {length}")
