"""Checks a Wavefront OBJ file and writes it with one statement per line, triangles only, indices from 1."""

import re
from io import StringIO
from itertools import pairwise
from math import isfinite

from ulna.description.meshes.mesh_files import MAX_TRIANGLES, Rewritten

_SURFACES = ("surf", "bzp", "bsp", "cdc", "cdp")
_MAX_MATERIALS = 1000  # trimesh takes time by their number squared
_MAX_WORDS = MAX_TRIANGLES + 4  # of a line: one more corner than a face with the maximum number of triangles


def rewritten_obj(data: bytes, *, materials: bool) -> Rewritten:
    """Its vertices, texture coordinates, normals and faces, sorted by material on request.

    Source: Wavefront, Advanced Visualizer, appendix B1.

    Lines end in LF, CR LF or CR, may be indented, and continue after a backslash. A negative index counts back from its place in
    the file. As in Assimp, a vertex of four numbers is homogeneous, one of six has a color. A face of more than three vertices is
    a fan. Lines and points have no faces and are omitted, as are groups.
    """
    lists: dict[str, list[str]] = {"v": [], "vt": [], "vn": []}
    faces = {"": StringIO()}  # by the line that names their material
    material = ""
    libraries: list[str] = []
    highest, n_triangles, all_colored = 0, 0, True
    for number, line in _lines(data):
        words = line.split(None, _MAX_WORDS)
        match words[0] if words else "#":
            case "v":
                vertex = _vertex(words[1:], number)
                all_colored &= len(vertex) == 6
                lists["v"].append(_joined(vertex))
            case "vt" | "vn" as kind:
                lists[kind].append(" ".join(words[1:4]))
            case "f" | "fo":  # codespell:ignore fo
                n_triangles += max(0, len(words) - 3)
                if n_triangles > MAX_TRIANGLES:
                    raise ValueError(f"line {number}: it has more than {MAX_TRIANGLES} triangles, the most that are read")
                corners = [_corner(word, lists, number) for word in words[1:]]
                highest = max([highest, *(int(corner.partition("/")[0]) for corner in corners)])
                faces[material].writelines(f"f {corners[0]} {b} {c}\n" for b, c in pairwise(corners[1:]))
            case "usemtl" if materials:
                material = _material(words, faces, number)
            case "mtllib":
                libraries.append(line.strip())
            case word if word in _SURFACES:
                raise ValueError(f"line {number}: it has curved surfaces ({word}), which are not read")
    if highest > len(lists["v"]):
        raise ValueError(f"a face refers to vertex {highest}; there are {len(lists['v'])}")
    vertices = lists["v"] if all_colored else [" ".join(vertex.split()[:3]) for vertex in lists["v"]]
    text = [*libraries[:1], *(f"v {vertex}" for vertex in vertices)]
    text += [f"{kind} {row}" for kind in ("vt", "vn") for row in lists[kind]]
    text += [f"{named}{of_it.getvalue()}" for named, of_it in faces.items()]
    return Rewritten("\n".join(text).encode(), n_triangles)


def _lines(data: bytes) -> list[tuple[int, str]]:
    """The lines with their numbers; continued lines are joined."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    number, lines = 1, []
    for line in re.split(r"(?<!\\)\n", text):
        lines.append((number, line.replace("\\\n", " ")))
        number += 1 + line.count("\\\n")
    return lines


def _vertex(words: list[str], number: int) -> list[float]:
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) not in (3, 4, 6, 7) or not all(map(isfinite, values)) or (len(values) == 4 and values[3] == 0):
        raise ValueError(f"line {number}: {' '.join(words)[:60]!r} is not a vertex of finite numbers")
    if len(values) == 4:
        return [value / values[3] for value in values[:3]]
    return values[:6]


def _material(words: list[str], faces: dict[str, StringIO], number: int) -> str:
    """The line that names a material, which is registered among the faces."""
    line = " ".join(words) + "\n"
    faces.setdefault(line, StringIO())
    if len(faces) > _MAX_MATERIALS + 1:
        raise ValueError(f"line {number}: it has more than {_MAX_MATERIALS} materials, the most that are read")
    return line


def _corner(word: str, lists: dict[str, list[str]], number: int) -> str:
    """One corner of a face, ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``, with indices counted from 1."""
    parts = word.split("/")
    try:
        indices = [int(part) if part else None for part in parts]
    except ValueError:
        indices = []
    counts = [len(lists[kind]) for kind in ("v", "vt", "vn")]
    absolute = [n + 1 + i if i is not None and i < 0 else i for i, n in zip(indices, counts, strict=False)]
    if not 1 <= len(indices) <= 3 or absolute[0] is None or any(i is not None and i < 1 for i in absolute):
        raise ValueError(f"line {number}: {word[:30]!r} is not a corner of a face")
    return "/".join("" if i is None else str(i) for i in absolute)


def _joined(values: list[float]) -> str:
    return " ".join(map(repr, values))
