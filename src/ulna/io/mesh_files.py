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
            FileError: It is not there, may not be read, or is no mesh; the message says which, and what was tried.
        """
        scheme, separator, rest = uri.partition("://")
        if Path(uri).suffix.lower() not in MESHES:
            raise FileError(uri, f"is not read as a mesh; {', '.join(MESHES)} are")
        try:
            return self._in_package(uri, rest) if scheme == "package" else self._plain(uri, rest if separator else uri)
        except (OSError, ValueError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(uri, str(error)) from None  # a name that no file system takes

    def beside(self, mesh: Path, name: str) -> Path:
        """A file that a mesh names, as a texture: in the mesh's folder, or where the description may read."""
        path = mesh.parent / unquote(name)
        if not (self.fence.admits(str(path)) or path.resolve().is_relative_to(mesh.parent.resolve())):
            raise FileError(name, f"lies outside {mesh.parent}, whose {mesh.name} names it")
        return path

    def _plain(self, uri: str, given: str) -> Path:
        path = Path(unquote(given)) if self.folder is None else self.folder / unquote(given)
        if not self.fence.admits(str(path)):
            raise FileError(uri, "lies outside the description's folder, its package and package_dirs, so it is not read")
        if not path.is_file():
            raise FileError(uri, f"no such file; tried {path}")
        return path

    def _in_package(self, uri: str, rest: str) -> Path:
        name, _, inside = rest.partition("/")
        inside = os.path.normpath(unquote(inside).lstrip("/"))
        if not name or name.startswith(".") or inside.startswith(".."):
            raise FileError(uri, "leads out of its package, so it is not read")
        given = set(package_folders(name, None, self.package_dirs))
        folders = dict.fromkeys(package_folders(name, self.folder, self.package_dirs))
        holding = [folder for folder in folders if (folder / inside).is_file()]
        for folder in holding:
            if folder in given or (folder / "package.xml").is_file():
                self.fence.admit(folder)  # for its textures
                return folder / inside
        if holding:
            raise FileError(uri, f"{holding[0]} has no package.xml; if it is the package, name its folder in package_dirs")
        raise FileError(uri, f"no such file; tried {'; '.join(str(folder / inside) for folder in folders)}")
