"""The files behind a description's meshes, as far as a description that a stranger wrote may lead to them."""

import os
from pathlib import Path
from urllib.parse import unquote

from ulna.errors import FileError
from ulna.io.fence import Fence
from ulna.io.packages import package_folders
from ulna.model.description import Description

MESHES = (".stl", ".obj", ".dae", ".ply", ".off", ".glb", ".gltf")


class MeshFiles:
    """Finds meshes in the description's folder, its package, ``package_dirs``, and packages found; and nowhere else.

    Like a xacro document, a description may name ``file:///etc/passwd`` or climb with ``..``; what it names would be served.
    """

    def __init__(self, description: Description) -> None:
        self.folder, self.package_dirs = description.folder, description.package_dirs
        self.fence = Fence(self.folder, [str(folder) for folder in self.package_dirs])

    def find(self, uri: str) -> Path:
        """The file behind ``package://``, ``file://`` or a path that is relative to the description.

        Raises:
            FileError: It is not there, may not be read, or is no mesh; the message says which, and lists every path tried.
        """
        scheme, separator, rest = uri.partition("://")
        if Path(uri).suffix.lower() not in MESHES:
            raise FileError(uri, f"is not read as a mesh; {', '.join(MESHES)} are")
        try:
            candidates = self._in_package(uri, rest) if scheme == "package" else [self._plain(rest if separator else uri)]
            found = next((path for path in candidates if path.is_file()), None)
        except (OSError, ValueError) as error:  # a name that no file system takes
            raise FileError(uri, getattr(error, "message", "") or str(error)) from None
        if found is None:
            raise FileError(
                uri, f"no such file; tried {'; '.join(map(str, candidates)) or 'no folder, for there is no such package'}"
            )
        return found

    def beside(self, mesh: Path, name: str) -> Path:
        """A file that a mesh names, as a texture."""
        path = mesh.parent / unquote(name)
        if not (self.fence.admits(str(path)) or self._in(mesh.parent, path)):
            raise FileError(name, f"lies outside {mesh.parent}, whose {mesh.name} names it")
        return path

    def _plain(self, given: str) -> Path:
        path = Path(unquote(given)) if self.folder is None else self.folder / unquote(given)
        if not self.fence.admits(str(path)):
            raise FileError(given, "lies outside the description's folder, its package and package_dirs, so it is not read")
        return path

    def _in_package(self, uri: str, rest: str) -> list[Path]:
        name, _, inside = rest.partition("/")
        inside = os.path.normpath(unquote(inside).lstrip("/"))
        if not name or name.startswith(".") or inside.startswith(".."):
            raise FileError(uri, "leads out of its package, so it is not read")
        given = set(package_folders(name, None, self.package_dirs))
        folders = dict.fromkeys(package_folders(name, self.folder, self.package_dirs))
        return [folder / inside for folder in folders if folder in given or (folder / "package.xml").is_file()]

    @staticmethod
    def _in(folder: Path, path: Path) -> bool:
        return path.resolve().is_relative_to(folder.resolve())
