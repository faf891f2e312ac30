"""Checks mesh files: missing, unreadable, or of a size that suggests another unit."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
from lxml import etree

from ulna.description.meshes.hulls import mesh_reader
from ulna.description.meshes.mesh_files import CHECKED, Located, MeshFiles
from ulna.description.packages import resolve_uri
from ulna.errors import FileError, MissingExtraError, listed
from ulna.inspection.elements import numbers, of_robot
from ulna.inspection.links import size_findings
from ulna.inspection.result import Finding, Severity


def mesh_findings(root: etree._Element, described: Located) -> Iterator[Finding]:
    """What is wrong with the files of meshes, each looked at once, as far as the description may lead to them."""
    files, folder, package_dirs = MeshFiles(described), described.folder, described.package_dirs
    users: dict[tuple[str, tuple[float, ...]], list[etree._Element]] = defaultdict(list)
    for mesh in root.iterfind("link/*/geometry/mesh"):
        users[mesh.get("filename", ""), numbers(mesh, "scale") or (1.0, 1.0, 1.0)].append(mesh)
    missing: dict[str, list[tuple[str, etree._Element]]] = defaultdict(list)
    unread: dict[str, int] = defaultdict(int)
    reader, lacking = _reader()
    for (uri, scale), meshes in users.items():
        if min(map(abs, scale)) == 0:
            yield Finding(Severity.WARNING, of_robot(meshes[0]), f"mesh {_short(uri)} is scaled to nothing", meshes[0].sourceline)
            continue
        path, _ = _resolved(uri, folder, package_dirs)
        if path is None:
            missing[_home(uri)].append((uri, meshes[0]))
        elif path.suffix.lower() not in CHECKED:
            unread[f"of kind {path.suffix.lower()!r} were found, but not read"] += 1
        elif reader is None:
            unread[f"were found, but not read: {lacking}"] += 1
        else:
            yield from _content_findings(uri, files, reader, scale, meshes[0])
    for home, some in missing.items():
        yield _missing(home, some, folder, package_dirs)
    for words, count in unread.items():
        yield Finding(Severity.NOTE, "document", f"{count} meshes {words}")


def _reader() -> tuple[ModuleType | None, str]:
    """What reads meshes; or None, and what to install."""
    try:
        return mesh_reader(), ""
    except MissingExtraError as error:
        return None, str(error)


def _content_findings(
    uri: str, files: MeshFiles, reader: ModuleType, scale: tuple[float, ...], mesh: etree._Element
) -> Iterator[Finding]:
    name = _short(uri)
    try:
        path = files.find(uri)
        extents = np.ptp(reader.used_points(reader.read_scene(path, reader.mesh_bytes(path))), axis=0).tolist()
    except FileError as error:
        reason = error.message.removeprefix("cannot be read: ")
        yield Finding(Severity.WARNING, of_robot(mesh), f"mesh {name} cannot be read: {reason}", mesh.sourceline)
        return
    scaled = [abs(extent * factor) for extent, factor in zip(extents, scale, strict=True)]
    yield from size_findings(f"mesh {name}", scaled, of_robot(mesh), mesh.sourceline)


def _missing(home: str, some: list[tuple[str, etree._Element]], folder: Path | None, package_dirs: Sequence[Path]) -> Finding:
    """One finding for all missing meshes of a package or a folder, with every path tried for the first."""
    uri, mesh = some[0]
    tried = tuple(str(path) for path in _resolved(uri, folder, package_dirs)[1])
    found_none = "not found" if tried else f"not found, as {uri[:80]!r} leads nowhere"
    count = f"{len(some)} mesh{'es' * (len(some) > 1)}"
    message = f"{count} of {home} {found_none}: {listed([_short(each) for each, _ in some])}"
    return Finding(Severity.WARNING, of_robot(mesh) if len(some) == 1 else "document", message, mesh.sourceline, tried)


def _resolved(uri: str, folder: Path | None, package_dirs: Sequence[Path]) -> tuple[Path | None, list[Path]]:
    try:
        return resolve_uri(uri, folder, package_dirs)
    except OSError:  # a name that no file system takes
        return None, []


def _home(uri: str) -> str:
    scheme, separator, rest = uri.partition("://")
    if scheme == "package" and separator:
        return f"package {rest.partition('/')[0]!r}"
    return f"folder {uri.rpartition('/')[0] or '.'!r}"


def _short(uri: str) -> str:
    return uri.rpartition("/")[2]
