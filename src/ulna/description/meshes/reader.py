"""Reads a mesh file with trimesh, for collision checking and for drawing alike.

A file of a format with many notations is first rewritten in one notation (``stl``, ``obj``, ``collada``). Afterwards the
triangles are counted. So a file is read completely, or refused.
"""

from collections.abc import Iterable
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import collada  # noqa: F401 -- without it trimesh reads no Collada, and does not say why
import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.resolvers import Resolver

from ulna.description.file_bytes import regular_file_bytes
from ulna.description.file_costs import check_ply, check_text
from ulna.description.meshes.collada import rewritten_collada
from ulna.description.meshes.gltf import check_gltf
from ulna.description.meshes.mesh_files import MAX_TRIANGLES, MeshFiles, Rewritten
from ulna.description.meshes.obj import rewritten_obj
from ulna.description.meshes.stl import rewritten_stl
from ulna.errors import FileError, count_of

MAX_BYTES = 100_000_000
_MAX_NUMBERS_OF_OFF = 10_000_000
_MAX_PIXELS = 8192 * 8192  # of all textures of a file, which are decoded when the page is drawn
_TEXTURES = ("image", "baseColorTexture", "emissiveTexture", "normalTexture", "occlusionTexture", "metallicRoughnessTexture")


def mesh_bytes(path: Path) -> bytes:
    """The bytes of a mesh file."""
    try:
        data = regular_file_bytes(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        raise FileError(str(path), " ".join(str(error).split())) from None
    if len(data) > MAX_BYTES:
        raise FileError(str(path), f"is a mesh of more than {MAX_BYTES / 1e6:.0f} MB, the most that is read")
    return data


def read_scene(path: Path, data: bytes, beside: Resolver | None = None) -> trimesh.Scene:
    """The triangles of a mesh file, Collada's in meters; each instance is a geometry of its own.

    Args:
        path: The file; its extension gives the format, and errors name it.
        data: Its bytes.
        beside: Reads the files that it refers to: materials, textures, buffers. Without it they are skipped.
    """
    try:
        if beside is not None:
            with suppress(Exception):  # materials may be invalid even if the triangles are valid
                return _checked(path.suffix.lower(), data, beside)
        return _checked(path.suffix.lower(), data, None)
    except MemoryError:
        raise FileError(str(path), "cannot be read: out of memory") from None
    except Exception as error:  # noqa: BLE001 -- trimesh and its dependencies raise any exception
        raise FileError(str(path), f"cannot be read: {' '.join(str(error).split())[:200] or type(error).__name__}") from None


def used_points(scene: trimesh.Scene) -> NDArray[np.float64]:
    """The points that triangles use, shape (n, 3); other vertices of the file are not part of the mesh."""
    return np.concatenate([vertices[np.unique(faces)] for vertices, faces in _parts(scene)])


def merged(scene: trimesh.Scene) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """All triangles: distinct vertices, shape (n, 3), and triangles, shape (m, 3)."""
    points, triangles = [], []
    for vertices, faces in _parts(scene):
        triangles.append(faces + sum(map(len, points)))
        points.append(vertices)
    vertices, index = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    return vertices, index.reshape(-1)[np.concatenate(triangles)]


def _checked(kind: str, data: bytes, beside: Resolver | None) -> trimesh.Scene:
    rewritten = _rewritten(kind, data, materials=beside is not None)
    if rewritten is not None and rewritten.n_triangles > MAX_TRIANGLES:
        raise ValueError(f"it has {rewritten.n_triangles} triangles; up to {MAX_TRIANGLES} are read")
    options: dict[str, Any] = {"skip_materials": True} if beside is None and kind == ".obj" else {}
    stream = BytesIO(data if rewritten is None else rewritten.data)
    resolver = _NoFiles() if beside is None else beside
    with np.errstate(all="ignore"):  # numbers that are not finite are refused below
        scene = trimesh.load_scene(stream, file_type=kind[1:], resolver=resolver, process=False, **options)
    _check(scene, rewritten)
    return scene


def _rewritten(kind: str, data: bytes, *, materials: bool) -> Rewritten | None:
    match kind:
        case ".stl":
            return rewritten_stl(data)
        case ".obj":
            return rewritten_obj(data, materials=materials)
        case ".dae":
            return rewritten_collada(data, materials=materials)
        case ".ply":
            check_ply(data)
        case ".glb" | ".gltf":
            check_gltf(kind, data)
        case ".off":
            check_text(data, _MAX_NUMBERS_OF_OFF)
    return None


def _parts(scene: trimesh.Scene) -> Iterable[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Vertices in the scene and triangles of each placed geometry."""
    for name in scene.graph.nodes_geometry:
        T, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            with np.errstate(invalid="ignore", over="ignore"):  # numbers that are not finite are refused in ``_check``
                yield np.asarray(mesh.vertices) @ T[:3, :3].T + T[:3, 3], np.asarray(mesh.faces)


def _check(scene: trimesh.Scene, rewritten: Rewritten | None) -> None:
    parts = list(_parts(scene))
    found = sum(len(faces) for _, faces in parts)
    if not found:
        raise ValueError("it has no triangles")
    if rewritten is not None and found != rewritten.n_triangles:
        raise ValueError(f"{found} of its {count_of(rewritten.n_triangles, 'triangle')} can be read")
    if found > MAX_TRIANGLES:
        raise ValueError(f"it has {found} triangles; up to {MAX_TRIANGLES} are read")
    for vertices, faces in parts:
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise ValueError("a triangle refers to a vertex that does not exist")
        if not np.isfinite(vertices).all():
            raise ValueError("it has points that are not finite")
    _check_textures(scene)


def _check_textures(scene: trimesh.Scene) -> None:
    """Limit the sizes of images, read from their headers alone: a small file may contain a large picture."""
    materials = [getattr(mesh.visual, "material", None) for mesh in scene.geometry.values() if isinstance(mesh, trimesh.Trimesh)]
    images = {id(image): image for one in materials for name in _TEXTURES if (image := getattr(one, name, None)) is not None}
    n_pixels = sum(int(np.prod(image.size)) for image in images.values())
    if n_pixels > _MAX_PIXELS:
        raise ValueError(f"its textures have {n_pixels} pixels; up to {_MAX_PIXELS} are read")


class NeighborFiles(Resolver):
    """Reads the files that a mesh refers to, such as textures, from its folder or the description's readable folders."""

    def __init__(self, files: MeshFiles, mesh: Path) -> None:
        self._files, self._mesh = files, mesh

    def get(self, key: str) -> bytes:
        """The bytes of a file."""
        return mesh_bytes(self._files.beside(self._mesh, key))

    def write(self, name: str, data: object) -> None:
        """Not supported."""
        raise NotImplementedError(f"{name} would be written")

    def namespaced(self, namespace: str) -> Resolver:
        """Not supported."""
        raise NotImplementedError(namespace)

    def keys(self) -> Iterable[str]:
        """An empty list: files are found by name only."""
        return ()


class _NoFiles(NeighborFiles):
    """Refuses every file that a mesh refers to."""

    def __init__(self) -> None:
        pass

    def get(self, key: str) -> bytes:
        raise FileError(key, "a mesh refers to this file, which is not needed")
