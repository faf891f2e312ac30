"""Reads the shape of an obstacle from a file that a person uploads: the hull or the pieces of a mesh, or a cloud of points."""

import re
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import trimesh
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.grids import Obstacle
from ulna.description.meshes.decompose import pieces_of_file
from ulna.description.meshes.hulls import hull_of
from ulna.description.meshes.mesh_files import CHECKED
from ulna.description.meshes.reader import MOST_BYTES
from ulna.description.shapes import ConvexMesh
from ulna.errors import FileError

MOST_POINTS = 100_000  # of a cloud that a browser draws, and that a scene file holds
RADIUS = 0.01  # [m] of the points of a new cloud
_TYPES = {"F": "f", "I": "i", "U": "u"}  # of a .pcd, as NumPy has them


def shapes_of_file(
    name: str, content: bytes, *, scale: float = 1.0, pieces: bool = False, announce: Callable[[str], object] = lambda _: None
) -> tuple[Obstacle, ...]:
    """The shapes of a file, in the frame of the file: one, or the convex pieces of a mesh.

    Args:
        name: The name of the file; its ending gives the format.
        content: Its bytes.
        scale: The unit of the file [m].
        pieces: Whether a mesh is decomposed into convex pieces, which takes seconds to minutes; else its convex hull is taken.
        announce: Called with a message before a decomposition.

    Raises:
        FileError: The format is not known, or the file cannot be read, is too long or has too many points.
        InputError: It reaches farther than shapes may, or a point is infinite.
        MissingExtraError: What reads meshes is not installed, or what decomposes them.
    """
    ending = Path(name).suffix.lower()
    if len(content) > MOST_BYTES:
        raise FileError(name, f"has more than {MOST_BYTES // 1_000_000} MB, the most that is read")
    if ending in CHECKED:
        return _mesh(name, content, scale, announce if pieces else None)
    if ending not in READERS:
        raise FileError(name, f"ends in none of {', '.join(ENDINGS)}")
    try:
        points = READERS[ending](content).astype(np.float64) * scale
    except MemoryError:
        raise FileError(name, "cannot be read: out of memory") from None
    except Exception as error:  # noqa: BLE001 - trimesh and its dependencies raise any exception
        raise FileError(name, f"cannot be read: {' '.join(str(error).split())[:200] or type(error).__name__}") from None
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        raise FileError(name, f"has an array of shape {points.shape}; points of shape (n, 3) are expected")
    points = points[:, :3]
    if ending == ".ply" and _ply_counts(content).get("face", 0):
        return (ConvexMesh.from_points(points),)
    if len(points) > MOST_POINTS:
        words = f"has {len(points)} points, of which the page takes {MOST_POINTS}; PointCloud.thinned makes fewer of them"
        raise FileError(name, words)
    return (PointCloud(points, RADIUS),)


def _mesh(name: str, content: bytes, scale: float, announce: Callable[[str], object] | None) -> tuple[ConvexMesh, ...]:
    """The hull of a mesh, or its pieces where ``announce`` is given."""
    with TemporaryDirectory(prefix="ulna-") as folder:
        path = Path(folder, f"mesh{Path(name).suffix.lower()}")
        path.write_bytes(content)
        try:
            if announce is None:
                return (hull_of(path, (scale, scale, scale)),)
            return tuple(ConvexMesh(points * scale) for points in pieces_of_file(path, announce).points)
        except FileError as error:
            raise FileError(name, error.message) from None


def _npy(content: bytes) -> NDArray:
    """An array of points, shape (n, 3) or (H, W, 3)."""
    array = np.load(BytesIO(content), allow_pickle=False)
    return array.reshape(-1, array.shape[-1]) if array.ndim > 2 else array


def _text(content: bytes) -> NDArray[np.float64]:
    """Lines of numbers between spaces, commas or semicolons, the first three a point; the first line may be names."""
    lines = [re.sub(r"[,;\t]", " ", line) for line in content.decode(errors="replace").splitlines()]
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith(("#", "//"))]
    if rows and not re.search(r"\d", rows[0]):
        rows = rows[1:]
    return np.loadtxt(rows, usecols=(0, 1, 2), ndmin=2) if rows else np.empty((0, 3))


def _ply_counts(content: bytes) -> dict[str, int]:
    """How many of each element the header of a .ply states."""
    head = content.partition(b"end_header")[0].decode(errors="replace")
    return {kind: int(count) for kind, count in re.findall(r"^element (\w+) (\d+)", head, re.MULTILINE)}


def _ply(content: bytes) -> NDArray[np.float64]:
    """The vertices of a .ply, whether triangles use them or not."""
    scene = trimesh.load_scene(BytesIO(content), file_type="ply", process=False)
    points = np.concatenate([np.asarray(part.vertices) for part in scene.geometry.values()])
    stated = _ply_counts(content).get("vertex", 0)
    if len(points) != stated:
        raise ValueError(f"{len(points)} of its {stated} points can be read")
    return points


def _pcd(content: bytes) -> NDArray[np.float64]:
    """The fields x, y, z of a .pcd, as text or binary. Source: Point Cloud Library, The PCD file format, version 0.7."""
    found = re.search(rb"^DATA +(\w+)\r?\n", content, re.MULTILINE)
    if found is None:
        raise ValueError("it has no line DATA")
    lines = content[: found.start()].decode(errors="replace").splitlines()
    head = {words[0]: words[1:] for words in map(str.split, lines) if words}
    fields, n = head["FIELDS"], int(head["POINTS"][0])
    counts = [int(count) for count in head.get("COUNT", ["1"] * len(fields))]
    body, form = content[found.end() :], found[1].decode()
    if form == "ascii":
        first = np.cumsum([0, *counts])
        columns = [int(first[fields.index(axis)]) for axis in "xyz"]
        points = np.loadtxt(body.decode(errors="replace").splitlines(), usecols=columns, ndmin=2)
    elif form == "binary":
        kinds = [f"<{_TYPES[kind]}{size}" for kind, size in zip(head["TYPE"], head["SIZE"], strict=True)]
        names = [field if field in "xyz" else f"{field} {k}" for k, field in enumerate(fields)]
        row = np.dtype([(name, kind, (count,)) for name, kind, count in zip(names, kinds, counts, strict=True)])
        rows = np.frombuffer(body[: n * row.itemsize], row)
        points = np.column_stack([rows[axis] for axis in "xyz"])
    else:
        raise ValueError(f"its points are {form}; ascii and binary are read")
    if len(points) != n:
        raise ValueError(f"{len(points)} of its {n} points can be read")
    return points


READERS: dict[str, Callable[[bytes], NDArray]] = {".npy": _npy, ".xyz": _text, ".csv": _text, ".ply": _ply, ".pcd": _pcd}
ENDINGS = (*CHECKED, *READERS)
