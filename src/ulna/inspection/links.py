"""Checks links: shapes and mesh files without volume, missing, or of a size that suggests another unit."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
from lxml import etree

from ulna.description.meshes.hulls import mesh_reader
from ulna.description.meshes.mesh_files import CHECKED, Located
from ulna.description.packages import resolve_uri
from ulna.description.unread import of_robot
from ulna.errors import FileError, MissingExtraError, count_of, listed
from ulna.inspection.boxes import Boxes
from ulna.inspection.elements import finding_at, number, numbers
from ulna.inspection.result import ERROR, NOTE, WARNING, Finding

LARGEST, SMALLEST = 20.0, 1e-3  # [m], bounds on the size of an arm's part; sizes beyond them suggest another unit


def shape_findings(root: etree._Element) -> Iterator[Finding]:
    """Findings about boxes, spheres, cylinders and capsules, and about links without shapes."""
    for kind in ("visual", "collision"):
        for element in root.iterfind(f"link/{kind}"):
            geometry = element.find("geometry")
            if geometry is None or not len(geometry):
                yield finding_at(ERROR, element, f"<{kind}> has no <geometry>")
                continue
            yield from _primitive_findings(geometry[0], kind)
        yield from _links_without(root, kind)


def _primitive_findings(shape: etree._Element, kind: str) -> Iterator[Finding]:
    extents = _extents(shape)
    if extents is None:
        return
    if min(extents) < 0:
        yield finding_at(ERROR, shape, f"{kind} {shape.tag} has a negative length")
    elif min(extents) == 0:
        yield finding_at(WARNING if kind == "collision" else NOTE, shape, f"{kind} {shape.tag} has no volume")
    else:
        yield from _size_findings(f"{kind} {shape.tag}", extents, shape)


def _size_findings(what: str, extents: Sequence[float], element: etree._Element) -> Iterator[Finding]:
    """A warning if the extents [m] do not suit any part of a robot."""
    words = " x ".join(f"{extent:.3g}" for extent in extents)
    if max(extents) > LARGEST:
        yield finding_at(WARNING, element, f"{what} is {words} m: millimeters? Lengths are meters")
    elif 0 < max(extents) < SMALLEST:
        yield finding_at(WARNING, element, f"{what} is {words} m: smaller than a millimeter; scaled twice?")


def _extents(shape: etree._Element) -> tuple[float, ...] | None:
    if shape.tag == "box":
        return numbers(shape, "size")
    radius = number(shape, "radius")
    if radius is None or shape.tag not in ("sphere", "cylinder", "capsule"):
        return None
    length = 2 * radius if shape.tag == "sphere" else number(shape, "length")
    return None if length is None else (2 * radius, 2 * radius, length)


def _links_without(root: etree._Element, kind: str) -> Iterator[Finding]:
    """One note for all links without such shapes; frames without any shape, such as tool points, do not count."""
    bare = [link for link in root.iterfind("link") if link.find(kind) is None]
    if bare and root.find(f"link/{kind}") is None:
        yield Finding(NOTE, "document", f"no link has a {kind} shape")
        return
    other = "collision" if kind == "visual" else "visual"
    names = [link.get("name", "") for link in bare if link.find(other) is not None]
    if names:
        severity = WARNING if kind == "collision" else NOTE  # a visible shape that collides with nothing
        yield Finding(severity, "document", f"a {other} shape and no {kind} shape: {listed(names)}")


def mesh_findings(root: etree._Element, described: Located, boxes: Boxes) -> Iterator[Finding]:
    """Findings about mesh files within the description's folders; each file is read once."""
    users: dict[tuple[str, tuple[float, ...]], etree._Element] = {}  # the first use of each file and scale
    for mesh in root.iterfind("link/*/geometry/mesh"):
        users.setdefault((mesh.get("filename", ""), numbers(mesh, "scale") or (1.0, 1.0, 1.0)), mesh)
    missing: dict[str, list[tuple[str, etree._Element, tuple[str, ...]]]] = defaultdict(list)
    unread: Counter[tuple[str, str]] = Counter()
    lacking = _missing_reader_advice()
    for (uri, scale), mesh in users.items():
        if min(map(abs, scale)) == 0:
            yield finding_at(WARNING, mesh, f"mesh {_short(uri)} has a scale of 0")
            continue
        try:
            path, tried = resolve_uri(uri, described.folder, described.package_dirs)
        except OSError:  # an invalid file name
            path, tried = None, []
        if path is None:
            missing[_folder_of(uri)].append((uri, mesh, tuple(map(str, tried))))
        elif path.suffix.lower() not in CHECKED:
            unread[f" of kind {path.suffix.lower()!r}", "found, but not read"] += 1
        elif lacking:
            unread["", f"found, but not read: {lacking}"] += 1
        else:
            yield from _content_findings(uri, boxes, scale, mesh)
    for home, some in missing.items():
        yield _missing(home, some)
    for (of, words), count in unread.items():
        yield Finding(NOTE, "document", f"{count_of(count, 'mesh', 'meshes')}{of} {'was' if count == 1 else 'were'} {words}")


def _missing_reader_advice() -> str:
    """The advice to install a reader of meshes; empty if one is installed."""
    try:
        mesh_reader()
    except MissingExtraError as error:
        return str(error)
    return ""


def _content_findings(uri: str, boxes: Boxes, scale: tuple[float, ...], mesh: etree._Element) -> Iterator[Finding]:
    name = f"mesh {_short(uri)}"
    try:
        extents = np.ptp(boxes.box_of_file(uri), axis=0)
    except FileError as error:
        yield finding_at(WARNING, mesh, f"{name} cannot be read: {error.message.removeprefix('cannot be read: ')}")
        return
    yield from _size_findings(name, np.abs(extents * scale).tolist(), mesh)


def _missing(home: str, some: list[tuple[str, etree._Element, tuple[str, ...]]]) -> Finding:
    """One finding for all missing meshes of a package or a folder, with every path tried for the first."""
    uri, mesh, tried = some[0]
    found_none = "not found" if tried else f"not found: {uri[:80]!r} resolves to no file"
    count = f"{len(some)} mesh{'es' * (len(some) > 1)}"
    message = f"{count} of {home} {found_none}: {listed([_short(each) for each, _, _ in some])}"
    return Finding(WARNING, of_robot(mesh) if len(some) == 1 else "document", message, mesh.sourceline, tried)


def _folder_of(uri: str) -> str:
    scheme, separator, rest = uri.partition("://")
    if scheme == "package" and separator:
        return f"package {rest.partition('/')[0]!r}"
    return f"folder {uri.rpartition('/')[0] or '.'!r}"


def _short(uri: str) -> str:
    return uri.rpartition("/")[2]
