"""Reads the Panda's meshes from the small package dm-robotics-panda, if the description's own package is missing.

The triangles are those of franka_description (Apache-2.0). All but one of the package's material files are missing, so this file
has a table of the colors.
"""

import re
import sys
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path

import trimesh
from trimesh.resolvers import Resolver

from ulna.description.meshes.reader import mesh_bytes
from ulna.description.names.panda import INSTALL_MESHES
from ulna.errors import FileError

MESHES = "package://example-robot-data/robots/panda_description/meshes/visual/"
_FOLDER = Path("dm_robotics", "panda", "assets", "panda")
_FILES = (*(f"link{k}" for k in range(8)), "hand", "finger")
_WHITE, _GREY, _METAL = "0.98 0.98 0.98", "0.25 0.25 0.25", "0.9 0.92 0.93"
_COLORS = {
    **dict.fromkeys(("Gray", "Shell_001.001", "Shell001_001.001", "Shell009_001.001", "Part__Feature023_001.001"), _GREY),
    **dict.fromkeys(("Part__Feature_001_001_001_002", "Part__Feature002_001_003_001", "Shell001_001_001_003.001"), _GREY),
    **dict.fromkeys(("Part__Feature_009_005", "Part__Feature001_008_005", "Part__Feature_007"), _GREY),
    **dict.fromkeys(("Metal", "metal", "metal.002", "metal.003", "metal.004"), _METAL),
    **dict.fromkeys(("Part__Feature002_005_005", "Part__Feature005_001_005_001", "Part__Feature001_006"), _METAL),
    "Blue": "0.04 0.54 0.78",
    "Green": "0.1 0.75 0.2",
    "Red": "0.85 0.1 0.1",
}  # all other materials are white


def packaged_mesh(uri: str) -> Path | None:
    """The file of the package that replaces a mesh of the Panda's description; None if there is none."""
    name = uri.removeprefix(MESHES).removesuffix(".dae")
    if name == uri or name not in _FILES:
        return None
    found = (Path(entry) / _FOLDER / f"{name}.obj" for entry in sys.path if Path(entry).is_absolute())
    return next((path for path in found if path.is_file()), None)


def read_packaged(path: Path) -> trimesh.Scene:
    """The triangles of a file of the package, with their colors.

    Raises:
        FileError: The file cannot be read.
    """
    data = mesh_bytes(path)
    try:
        return trimesh.load_scene(BytesIO(data), file_type="obj", resolver=_Colors(data), process=False)
    except Exception as error:  # noqa: BLE001 -- trimesh raises any exception
        raise FileError(str(path), f"cannot be read ({type(error).__name__}); {INSTALL_MESHES} brings it anew") from None


class _Colors(Resolver):
    """Returns the table of colors as a Wavefront material file, whichever file a mesh names."""

    def __init__(self, data: bytes) -> None:
        self._names = dict.fromkeys(re.findall(r"^usemtl (\S+)", data.decode(errors="replace"), re.MULTILINE))

    def get(self, key: str) -> bytes:  # noqa: ARG002 -- part of the interface
        return "".join(f"newmtl {name}\nKd {_COLORS.get(name, _WHITE)}\n" for name in self._names).encode()

    def write(self, name: str, data: object) -> None:
        raise NotImplementedError(name)

    def namespaced(self, namespace: str) -> Resolver:
        raise NotImplementedError(namespace)

    def keys(self) -> Iterable[str]:
        return ()
