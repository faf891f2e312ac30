"""Resolves ``package://`` without ROS: folders of packages, and files of addresses."""

import os
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from urllib.parse import unquote

from ulna.description.file_bytes import regular_file_bytes
from ulna.description.xacro.child.addresses import path_of_address
from ulna.errors import InputError

_NAME = re.compile(r"<name>([^<]*+)</name>")
_LONGEST = 1_000_000  # bytes of a package.xml that are read
_LEVELS_ABOVE = 6  # folders


def as_package_dirs(package_dirs: Iterable[str | Path]) -> tuple[Path, ...]:
    """The folders given by a user as absolute paths, since the name of ``.`` or ``..`` is needed to find a package.

    Example:
        >>> as_package_dirs(["."]) == (Path.cwd(),)
        True
    """
    if isinstance(package_dirs, (str, Path)) or not isinstance(package_dirs, Iterable):
        raise InputError("package_dirs", f"{package_dirs!r}; a list of folders is expected")
    return tuple(map(_absolute, package_dirs))


def _absolute(folder: object) -> Path:
    if not isinstance(folder, (str, Path)):
        raise InputError("package_dirs", f"{folder!r} is not a folder; the path of a folder is expected")
    path = Path(folder)
    return path.resolve() if ".." in path.parts else path.absolute()  # a link keeps its name, which may be the package's


def package_folders(name: str, description_folder: Path | None, package_dirs: Iterable[str | Path] = ()) -> Iterator[Path]:
    """The folders that may be the package ``name``, in order of preference.

    ``package_dirs``, ROS's two path variables, the folders above the description, the data packages installed beside this Python.
    A folder is the package if it or its ``package.xml`` has that name.
    """
    for folder in map(Path, package_dirs):
        if _is_package(folder, name):
            yield folder
        yield folder / name
    for folder in _absolute_ones(os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
        yield folder if _is_package(folder, name) else folder / name
    for folder in _shares_of_ros():
        yield folder / name
    if description_folder is not None:
        for folder in folders_above(description_folder):
            yield folder if _is_package(folder, name) else folder / name
    for folder in _shares_of_python():
        yield folder / name


def folders_above(folder: Path) -> list[Path]:
    """A folder and those above it in which the package of a description may begin."""
    return [folder.resolve(), *folder.resolve().parents][:_LEVELS_ABOVE]


def installed_folders() -> Iterator[Path]:
    """The folders of installed packages: of ROS 2, and of the data packages of this Python."""
    yield from _shares_of_ros()
    yield from _shares_of_python()


def _shares_of_ros() -> Iterator[Path]:
    return (prefix / "share" for prefix in _absolute_ones(os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)))


def _shares_of_python() -> Iterator[Path]:
    return (entry / "cmeel.prefix" / "share" for entry in _absolute_ones(sys.path))


def _absolute_ones(folders: Iterable[str]) -> Iterator[Path]:
    """The absolute paths of some: a relative one would lead into whatever folder the process is in."""
    return (Path(folder) for folder in folders if isinstance(folder, str) and os.path.isabs(folder))  # noqa: PTH117 - text


def _is_package(folder: Path, name: str) -> bool:
    if folder.name == name:
        return True
    try:
        text = regular_file_bytes(folder / "package.xml", _LONGEST).decode(errors="replace")
    except (OSError, ValueError):
        return False
    declared = _NAME.search(text)
    return declared is not None and declared[1].strip() == name


def places(uri: str, description_folder: Path | None, package_dirs: Iterable[str | Path] = ()) -> dict[Path, Path | None]:
    """The possible paths of an address in order of preference, each with the folder of its package, or None.

    The address is ``package://``, ``file://`` or a plain path, the last two relative to the description. It may be
    percent-encoded, but a plain path is first tried as written. An address that leaves its package by ``..`` has no file.
    """
    scheme, _, rest = uri.partition("://")
    if scheme == "package":
        name, _, inside = rest.partition("/")
        inside = os.path.normpath(unquote(inside).lstrip("/"))
        if not name or name.startswith(".") or inside.startswith(".."):
            return {}
        return {folder / inside: folder for folder in package_folders(name, description_folder, package_dirs)}
    names = (path_of_address(rest),) if scheme == "file" else (uri, unquote(uri))
    return dict.fromkeys((description_folder or Path()) / name for name in names)


def resolve_uri(
    uri: str, description_folder: Path | None, package_dirs: Iterable[str | Path] = ()
) -> tuple[Path | None, list[Path]]:
    """The file of an address, or None; and every path tried."""
    candidates = list(places(uri, description_folder, package_dirs))
    return next((path for path in candidates if path.is_file()), None), candidates
