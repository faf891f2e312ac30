"""Checks an STL file and writes it as binary STL, which is unambiguous."""

import re

import numpy as np

from ulna.description.meshes.mesh_files import Rewritten

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84  # bytes: 80 of any text, 4 for the number of triangles
_FACET = b"facet normal x x x outer loop vertex x x x vertex x x x vertex x x x endloop endfacet".split()
_NUMBERS = np.array([word == b"x" for word in _FACET])


def rewritten_stl(data: bytes) -> Rewritten:
    """Binary STL unchanged; text converted to binary STL.

    It is binary if its length suits the number of triangles, as Assimp and trimesh decide too. A text must consist of whole
    facets of three vertices each: a truncated text is refused.
    """
    count = int.from_bytes(data[80:_HEADER], "little")
    if len(data) >= _HEADER and len(data) == _HEADER + _TRIANGLE.itemsize * count:
        return _finite(np.frombuffer(data, _TRIANGLE, count, _HEADER), data)
    numbers = _facets(data)
    triangles = np.zeros(len(numbers), _TRIANGLE)
    with np.errstate(over="ignore"):  # numbers that are too large become infinite
        triangles["normal"], triangles["corners"] = numbers[:, 0], numbers[:, 1:]
    return _finite(triangles, bytes(80) + len(triangles).to_bytes(4, "little") + triangles.tobytes())


def _finite(triangles: np.ndarray, data: bytes) -> Rewritten:
    """Binary STL; raises an error if a point is not finite, since some readers omit the point."""
    if not np.isfinite(triangles["corners"]).all():
        raise ValueError("it has points that are not finite")
    return Rewritten(data, len(triangles))


def _facets(data: bytes) -> np.ndarray:
    """The normal and the three corners of each facet of a text, shape (n, 4, 3)."""
    text = re.sub(rb"\r\n?", b"\n", data.removeprefix(b"\xef\xbb\xbf"))
    if not re.match(rb"\s*solid\b", text, re.IGNORECASE):
        raise ValueError("it is not an STL file: it neither has the length that its header gives, nor begins with 'solid'")
    words = []
    for line in text.split(b"\n"):
        some = line.split()
        if not some or some[0].lower() not in (b"solid", b"endsolid"):  # the name may be any text
            words += some
        elif b"endfacet" in line.lower():
            raise ValueError("a line has both facets and a name")
    if len(words) % len(_FACET):
        raise ValueError("its text does not consist of whole facets of three vertices; it may have been cut off")
    table = np.array(words, dtype="S").reshape(-1, len(_FACET))
    if not (np.char.lower(table[:, ~_NUMBERS]) == np.array(_FACET)[~_NUMBERS]).all():
        raise ValueError("its text does not consist of facets of three vertices")
    return table[:, _NUMBERS].astype(np.float64).reshape(-1, 4, 3)
