"""Finds the files of meshes, within the folders that a description may read, and defines what is read of them.

A description may come from a stranger, so not every file that it names is opened (``readable``).
"""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Protocol
from urllib.parse import unquote

from lxml import etree

from ulna.description.packages import places, resolve_uri
from ulna.description.readable import Readable
from ulna.errors import FileError, InputError, did_you_mean

CHECKED = (".stl", ".obj", ".dae")
"""The formats that are read completely: only these are used for collision checking."""
MOST_TRIANGLES = 4_000_000  # of all instances; a binary STL of MOST_BYTES has half of this


class Rewritten(NamedTuple):
    """The data that a mesh library reads in place of the file.

    Attributes:
        data: The file, rewritten in its own format.
        n_triangles: The number of triangles that a reader must find in it, over all instances.
    """

    data: bytes
    n_triangles: int


_OUTSIDE = "lies outside the description's folder, its package and package_dirs, so it is not read"
MESHES = (".stl", ".obj", ".dae", ".ply", ".off", ".glb", ".gltf")


class Located(Protocol):
    """A description, or anything else with the folders of its files."""

    @property
    def folder(self) -> Path | None: ...  # noqa: D102

    @property
    def package_dirs(self) -> tuple[Path, ...]: ...  # noqa: D102


class MeshFiles:
    """Finds meshes in the description's folder, its package, ``package_dirs``, and packages found; and nowhere else.

    A description from elsewhere could refer to ``file:///etc/passwd`` or use ``..``, and the viewer would serve that file.
    """

    def __init__(self, description: Located) -> None:
        self.folder, self.package_dirs = description.folder, description.package_dirs
        self.readable = Readable(self.folder, [str(folder) for folder in self.package_dirs])

    def find(self, uri: str) -> Path:
        """The file behind ``package://``, ``file://`` or a path that is relative to the description."""
        if Path(uri).suffix.lower() not in MESHES:
            raise FileError(uri, f"is not read as a mesh; {', '.join(MESHES)} are")
        try:
            return self._readable(uri)
        except (OSError, ValueError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(uri, str(error)) from None  # a name that no file system takes

    def beside(self, mesh: Path, name: str) -> Path:
        """A file that a mesh refers to, such as a texture: in the mesh's folder, or where the description may read."""
        path = mesh.parent / unquote(name)
        if not (self.readable.admits(str(path)) or path.resolve().is_relative_to(mesh.parent.resolve())):
            raise FileError(name, f"lies outside {mesh.parent}, the folder of {mesh.name}, which refers to it")
        return path

    def _readable(self, uri: str) -> Path:
        packages = places(uri, self.folder, self.package_dirs)
        if not packages:
            raise FileError(uri, "leads out of its package, so it is not read")
        admitted = [path for path, package in packages.items() if package is not None or self.readable.admits(str(path))]
        found = [path for path in admitted if path.is_file()]
        given = places(uri, None, self.package_dirs)
        reasons = []
        for path in found:
            package = packages[path]
            reason = "" if package is None else self.readable.admit_package(package, given=path in given)  # for its textures too
            if not reason and self.readable.admits(path):
                return path
            reasons.append(f"{package} {reason}; if it is the package, name its folder in package_dirs" if reason else _OUTSIDE)
        raise FileError(uri, reasons[0] if reasons else _refusal(packages, admitted))


def _refusal(packages: dict[Path, Path | None], admitted: list[Path]) -> str:
    return _OUTSIDE if len(admitted) < len(packages) else f"no such file; tried {'; '.join(map(str, admitted))}"


_KINDS = ("given", "file")
_NAMING_FILES = ("mesh", "texture")


def with_mesh_paths(kind: str, text: str, folder: Path | None, package_dirs: Iterable[str | Path]) -> str:
    """The text with mesh and texture paths as they are (``"given"``), or as absolute ``file://`` addresses (``"file"``)."""
    if kind not in _KINDS:
        raise InputError("mesh_paths", f"{kind!r} is not known{did_you_mean(str(kind), _KINDS)}")
    if kind == "given":
        return text
    root = etree.fromstring(text.encode(), etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False))
    named = [element for element in root.iter(*_NAMING_FILES) if element.get("filename")]
    package_dirs = list(package_dirs)
    found = {uri: resolve_uri(uri, folder, package_dirs) for uri in dict.fromkeys(e.get("filename", "") for e in named)}
    missing = [uri for uri, (path, _) in found.items() if path is None]
    for uri in missing[:1]:
        tried = "; ".join(map(str, found[uri][1])) or "nothing, for it leads out of its package"
        others = f" ({len(missing) - 1} more of this robot are missing)" if len(missing) > 1 else ""
        raise FileError(uri, f"no such file{others}; tried {tried}")
    for element in named:
        path, _ = found[element.get("filename", "")]
        element.set("filename", Path(path or "").resolve().as_uri())
    return etree.tostring(root.getroottree(), encoding="unicode")
