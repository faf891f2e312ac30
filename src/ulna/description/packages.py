"""Resolves ``package://`` without ROS: folders of packages, and files of addresses."""

import os
import re
import sys
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from urllib.parse import unquote

from ulna.description.file_bytes import regular_file_bytes
from ulna.description.xacro.child.addresses import path_of_address
from ulna.errors import InputError

_NAME = re.compile(r"<name>([^<]*+)</name>")
_LONGEST = 1_000_000  # bytes of a package.xml that are read
_LEVELS_ABOVE = 6  # folders
_MAX_NAMES = 10_000  # compared names of one folder


def as_package_dirs(package_dirs: Iterable[str | Path]) -> tuple[Path, ...]:
    """The user's folders as absolute paths, since a package search needs the name of ``.`` or ``..``.

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

    The order is ``package_dirs``, ROS's two path variables, the folders above the description, and the data packages next to this
    Python. A folder is the package if it or its ``package.xml`` has that name.
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
    """A folder and its ancestors, up to the possible root of a description's package."""
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
    """The absolute paths among folders: a relative one would depend on the working directory."""
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


_MESHES = {"mesh", "meshes", "visual", "collision", "assets", "stl", "obj", "dae"}
_TREE_LEVELS = 3  # folders above a description that has no package and no repository
_FIND = re.compile(r"\$\(find ([^)\s]+)\)/?(.*)", re.DOTALL)
NETWORK = ("http:", "https:", "ftp:")


def own_tree(folder: Path | None) -> Path | None:
    """The folder that a description shares with its meshes, and may read; None if the description is alone.

    It is its package, or the repository around it, or the nearest of the three folders above with a folder for meshes. It is
    never a home folder or one above, whose ``meshes`` would belong to someone else.
    """
    if folder is None:
        return None
    above, home = folders_above(folder), Path(os.path.expanduser("~")).resolve()  # noqa: PTH111 - it may not be known
    above = above[: next((k for k, path in enumerate(above) if home.is_relative_to(path)), len(above))]
    for kinds in (("package.xml",), (".git", "model.config", "manifest.xml")):
        for path in above:
            if any((path / kind).exists() for kind in kinds):
                return path
    return next((path for path in above[1 : 1 + _TREE_LEVELS] if _has_folder_for_meshes(path)), None)


def _has_folder_for_meshes(folder: Path) -> bool:
    try:
        with os.scandir(folder) as entries:
            names = [entry.name.lower() for entry in islice(entries, _MAX_NAMES)]
    except OSError:
        return False
    return not _MESHES.isdisjoint(names)


def places(uri: str, description_folder: Path | None, package_dirs: Iterable[str | Path] = ()) -> dict[Path, Path | None]:
    """The possible paths of an address in order of preference, each with the folder of its package, or None.

    The address is ``package://``, ``model://`` or ``$(find ...)``, or ``file:`` or a plain path, the last two relative to the
    description. It may be percent-encoded, but a plain path is first tried as written. Backslashes may separate. An address that
    leaves its package by ``..`` has no file. Last, the folders of the description's own tree are tried: a package may have
    another name there, or a path may begin at its package.
    """
    package_dirs = list(package_dirs)
    found: dict[Path, Path | None] = {}
    for one in dict.fromkeys((uri, uri.replace("\\", "/"))):
        for path, package in _places_of(one, description_folder, package_dirs):
            found.setdefault(path, package)
    return found


def _places_of(uri: str, folder: Path | None, package_dirs: list[str | Path]) -> Iterator[tuple[Path, Path | None]]:
    find = _FIND.fullmatch(uri.removeprefix("file://"))
    scheme, _, rest = ("package", "", f"{find[1]}/{find[2]}") if find else uri.partition("://")
    if uri.startswith(NETWORK):
        return
    tree = own_tree(folder)
    levels = [] if folder is None or tree is None else [path for path in folders_above(folder) if path.is_relative_to(tree)]
    if scheme in ("package", "model"):
        name, _, inside = rest.partition("/")
        inside = os.path.normpath(unquote(inside).lstrip("/"))
        if not name or name.startswith(".") or inside.startswith(".."):
            return
        yield from ((package / inside, package) for package in package_folders(name, folder, package_dirs))
        yield from ((level / inside, None) for level in levels)
        return
    if uri.startswith("file:"):
        path = uri.removeprefix("file:").removeprefix("//").removeprefix("localhost")
        names = (path_of_address(path),)
    else:
        names = (uri, unquote(uri))
    for name in names:
        yield (folder or Path()) / name, None
    for level in (*levels, *map(Path, package_dirs)):
        yield from ((level / name, None) for name in names if not os.path.isabs(name))  # noqa: PTH117 - text


def resolve_uri(
    uri: str, description_folder: Path | None, package_dirs: Iterable[str | Path] = ()
) -> tuple[Path | None, list[Path]]:
    """The file of an address, or None; and every path tried."""
    candidates = list(places(uri, description_folder, package_dirs))
    return next((path for path in candidates if path.is_file()), None), candidates
