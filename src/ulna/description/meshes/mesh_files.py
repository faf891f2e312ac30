"""Finds mesh files within the folders that a description may read, and defines their formats.

A description may come from a stranger, so not every file that it names is opened (``readable``).
"""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Protocol
from urllib.parse import unquote

from lxml import etree

from ulna.description.packages import NETWORK, own_tree, places, resolve_uri
from ulna.description.readable import Readable
from ulna.errors import FileError, InputError, case_twin, did_you_mean, twin_in_words

CHECKED = (".stl", ".obj", ".dae")
"""The formats that are read completely; only these are used for collision checking."""
MAX_TRIANGLES = 4_000_000  # of all instances; a binary STL of MAX_BYTES has half of this


class Rewritten(NamedTuple):
    """The data that a mesh library reads in place of the file.

    Attributes:
        data: The file, rewritten in its own format.
        n_triangles: The number of triangles that a reader must find in it, over all instances.
    """

    data: bytes
    n_triangles: int


_OUTSIDE = "lies outside the description's folder, its package or repository and package_dirs, so it is not read"
MESHES = (".stl", ".obj", ".dae", ".ply", ".off", ".glb", ".gltf")


class Located(Protocol):
    """A description, or another object with the folders of its files."""

    @property
    def folder(self) -> Path | None: ...  # noqa: D102

    @property
    def package_dirs(self) -> tuple[Path, ...]: ...  # noqa: D102


class MeshFiles:
    """Finds meshes only in the description's own tree (``own_tree``), ``package_dirs``, and packages found.

    A stranger's description could name any mesh of this machine, as ``file:///home/me/secret.stl`` or by ``..``, and the page
    would show it. So only the description's tree and the caller's folders are read.
    """

    def __init__(self, description: Located) -> None:
        self.folder, self.package_dirs = description.folder, description.package_dirs
        self.readable = Readable(self.folder, [str(folder) for folder in self.package_dirs])
        if (tree := own_tree(self.folder)) is not None:
            self.readable.admit(tree)

    def find(self, uri: str) -> Path:
        """The file behind ``package://``, ``file://`` or a path relative to the description."""
        if Path(uri).suffix.lower() not in MESHES:
            raise FileError(uri, f"is not read as a mesh; {', '.join(MESHES)} are")
        return self.located(uri)

    def located(self, uri: str) -> Path:
        """The file behind an address of any kind, included models too."""
        try:
            return self._readable(uri)
        except (OSError, ValueError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(uri, str(error)) from None  # an invalid file name

    def beside(self, mesh: Path, name: str) -> Path:
        """A file that a mesh refers to, such as a texture: in the mesh's folder, or in readable folders."""
        path = mesh.parent / unquote(name)
        if not (self.readable.admits(str(path)) or path.resolve().is_relative_to(mesh.parent.resolve())):
            raise FileError(name, f"lies outside {mesh.parent}, the folder of {mesh.name}, which refers to it")
        return path

    def _readable(self, uri: str) -> Path:
        packages = places(uri, self.folder, self.package_dirs)
        if uri.startswith(NETWORK):
            raise FileError(uri, "lies on the network, and nothing is downloaded: save it beside the description")
        if not packages:
            raise FileError(uri, "lies outside its package, so it is not read")
        admitted = [path for path, package in packages.items() if package is not None or self.readable.admits(str(path))]
        found = [path for path in admitted if path.is_file()]
        given = places(uri, None, self.package_dirs)
        reasons = []
        for path in found:
            package = packages[path]
            reason = "" if package is None else self.readable.admit_package(package, given=path in given)  # for its textures too
            if not reason and self.readable.admits(path):
                return path
            advice = f"{package} {reason}; if it is the right package: package_dirs=[{str(package)!r}]"
            reasons.append(advice if reason else f"{_OUTSIDE}; {self._advice(path)}")
        raise FileError(uri, reasons[0] if reasons else self._refusal(uri, packages, admitted))

    def _refusal(self, uri: str, packages: dict[Path, Path | None], admitted: list[Path]) -> str:
        """The reason why nothing was found, and the argument that finds it."""
        outside = [path for path in packages if path not in admitted]
        if outside and (there := next((path for path in outside if path.is_file()), None)):
            return f"{_OUTSIDE}; {self._advice(there)}"
        if outside and not any(".." in Path(uri).parts or path.is_absolute() for path in outside):
            return f"is relative, and text has no folder: give package_dirs=[FOLDER], where FOLDER/{uri} is the file"
        if outside and not admitted:
            return f"{_OUTSIDE}; and it does not exist"
        tried = f"no such file; tried {'; '.join(map(str, admitted))}"
        if twin := next((twin for path in admitted if (twin := case_twin(path)) is not None), None):
            return f"{tried}. Only upper and lower case differ from {twin}: rename one of them"
        package = next((uri.partition("://")[2].partition("/")[0] for path in packages.values() if path is not None), "")
        missing = package and not any(path is not None and path.is_dir() for path in packages.values())
        return f"{tried}. package_dirs=[...] names the folder that contains the package {package!r}" if missing else tried

    def _advice(self, path: Path) -> str:
        """Advise an argument of ``load`` that admits a file: its common folder with the description, or its own folder."""
        real, home = path.resolve(), Path(os.path.expanduser("~")).resolve()  # noqa: PTH111 - it may not be known
        shared = real.parent
        if self.folder is not None:
            common = Path(os.path.commonpath([real.parent, self.folder.resolve()]))
            shared = real.parent if home.is_relative_to(common) or len(common.parts) < _SHALLOWEST else common
        return f"to allow it: package_dirs=[{str(shared)!r}] (--package-dir {shared})"


_SHALLOWEST = 3  # parts of a path: "/", "home", "me"
_KINDS = ("given", "file")
_NAMING_FILES = ("mesh", "texture")


def with_mesh_paths(kind: str, text: str, folder: Path | None, package_dirs: Iterable[str | Path]) -> str:
    """The text with mesh and texture paths unchanged (``"given"``), or as absolute ``file://`` addresses (``"file"``)."""
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
        tried = "; ".join(map(str, found[uri][1])) or "nothing, because it lies outside its package"
        others = (
            f" ({len(missing) - 1} more of this robot {'is' if len(missing) == 2 else 'are'} missing)" if len(missing) > 1 else ""
        )
        twin = next(filter(None, map(twin_in_words, found[uri][1])), "")
        raise FileError(uri, f"no such file{others}; tried {tried}{twin}")
    for element in named:
        path, _ = found[element.get("filename", "")]
        element.set("filename", Path(path or "").resolve().as_uri())
    return etree.tostring(root.getroottree(), encoding="unicode")
