"""Checks links: shapes and mesh files without volume, missing, or of a size that suggests another unit; and inertia."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from types import ModuleType

import numpy as np
from lxml import etree

from ulna.description.meshes.hulls import mesh_reader
from ulna.description.meshes.mesh_files import CHECKED, Located, MeshFiles
from ulna.description.packages import resolve_uri
from ulna.description.unread import of_robot
from ulna.errors import FileError, MissingExtraError, count_of, listed
from ulna.inspection.elements import found, number, numbers
from ulna.inspection.result import ERROR, NOTE, WARNING, Finding

LARGEST, LEAST = 20.0, 1e-3  # m: what is larger or smaller than any part of an arm, and common in another unit
_ZERO = 1e-12  # relative to the largest moment
_ROUNDING = 1e-3  # relative: published inertias have three digits


def shape_findings(root: etree._Element) -> Iterator[Finding]:
    """What is wrong with boxes, spheres, cylinders and capsules, and which links have no shapes."""
    for kind in ("visual", "collision"):
        for element in root.iterfind(f"link/{kind}"):
            geometry = element.find("geometry")
            if geometry is None or not len(geometry):
                yield found(ERROR, element, f"<{kind}> has no <geometry>")
                continue
            yield from _primitive_findings(geometry[0], kind)
        yield from _without(root, kind)


def _primitive_findings(shape: etree._Element, kind: str) -> Iterator[Finding]:
    extents = _extents(shape)
    if extents is None:
        return
    if min(extents) < 0:
        yield found(ERROR, shape, f"{kind} {shape.tag} has a negative length")
    elif min(extents) == 0:
        yield found(WARNING if kind == "collision" else NOTE, shape, f"{kind} {shape.tag} has no volume")
    else:
        yield from _size_findings(f"{kind} {shape.tag}", extents, shape)


def _size_findings(what: str, extents: Sequence[float], element: etree._Element) -> Iterator[Finding]:
    """A warning if the extents [m] are those of no part of a robot."""
    words = " x ".join(f"{extent:.3g}" for extent in extents)
    if max(extents) > LARGEST:
        yield found(WARNING, element, f"{what} is {words} m: millimetres? Lengths are metres")
    elif 0 < max(extents) < LEAST:
        yield found(WARNING, element, f"{what} is {words} m: smaller than a millimetre; scaled twice?")


def _extents(shape: etree._Element) -> tuple[float, ...] | None:
    if shape.tag == "box":
        return numbers(shape, "size")
    radius = number(shape, "radius")
    if radius is None or shape.tag not in ("sphere", "cylinder", "capsule"):
        return None
    length = 2 * radius if shape.tag == "sphere" else number(shape, "length")
    return None if length is None else (2 * radius, 2 * radius, length)


def _without(root: etree._Element, kind: str) -> Iterator[Finding]:
    """One note for all links without such shapes; frames without any shape, as tool points are, go without saying."""
    bare = [link for link in root.iterfind("link") if link.find(kind) is None]
    if bare and root.find(f"link/{kind}") is None:
        yield Finding(NOTE, "document", f"no link has a {kind} shape")
        return
    other = "collision" if kind == "visual" else "visual"
    names = [link.get("name", "") for link in bare if link.find(other) is not None]
    if names:
        severity = WARNING if kind == "collision" else NOTE  # what is seen, and never touches anything
        yield Finding(severity, "document", f"a {other} shape and no {kind} shape: {listed(names)}")


def inertia_findings(root: etree._Element) -> Iterator[Finding]:
    """Masses that are not positive, and inertias that are not positive definite or break the triangle inequality."""
    massless: list[str] = []
    for link in root.iterfind("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass, moments = number(inertial.find("mass"), "value"), _principal_moments(inertial.find("inertia"))
        if mass == 0 and moments is not None and not moments.any():
            massless.append(link.get("name", ""))
            continue
        if mass is None or mass <= 0:
            yield found(WARNING, inertial, "mass is missing" if mass is None else f"mass is {mass:g} kg")
        if moments is None:
            yield found(WARNING, inertial, "inertia is missing, or not six numbers")
        elif not moments.any():
            yield found(WARNING, inertial, "inertia is zero")
        elif moments[0] <= _ZERO * moments[2]:
            least = "0" if abs(moments[0]) <= _ZERO * moments[2] else f"{moments[0]:.3g}"
            yield found(WARNING, inertial, f"inertia is not positive definite: a moment of {least}")
        elif moments[0] + moments[1] < moments[2] * (1 - _ROUNDING):
            message = f"inertia of no body: moments {moments[0]:.3g} + {moments[1]:.3g} < {moments[2]:.3g}"
            yield found(WARNING, inertial, message)
    if massless:
        yield Finding(NOTE, "document", f"mass and inertia are zero: {listed(massless)}")


def _principal_moments(inertia: etree._Element | None) -> np.ndarray | None:
    """The eigenvalues, ascending."""
    values = [number(inertia, key) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]
    if None in values:
        return None
    xx, xy, xz, yy, yz, zz = values
    return np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64))


def mesh_findings(root: etree._Element, described: Located) -> Iterator[Finding]:
    """What is wrong with the files of meshes, each looked at once, as far as the description may lead to them."""
    files = MeshFiles(described)
    users: dict[tuple[str, tuple[float, ...]], etree._Element] = {}  # the first of each file and scale
    for mesh in root.iterfind("link/*/geometry/mesh"):
        users.setdefault((mesh.get("filename", ""), numbers(mesh, "scale") or (1.0, 1.0, 1.0)), mesh)
    missing: dict[str, list[tuple[str, etree._Element, tuple[str, ...]]]] = defaultdict(list)
    unread: Counter[tuple[str, str]] = Counter()
    reader, lacking = _reader()
    for (uri, scale), mesh in users.items():
        if min(map(abs, scale)) == 0:
            yield found(WARNING, mesh, f"mesh {_short(uri)} is scaled to nothing")
            continue
        try:
            path, tried = resolve_uri(uri, described.folder, described.package_dirs)
        except OSError:  # a name that no file system takes
            path, tried = None, []
        if path is None:
            missing[_home(uri)].append((uri, mesh, tuple(map(str, tried))))
        elif path.suffix.lower() not in CHECKED:
            unread[f" of kind {path.suffix.lower()!r}", "found, but not read"] += 1
        elif reader is None:
            unread["", f"found, but not read: {lacking}"] += 1
        else:
            yield from _content_findings(uri, files, reader, scale, mesh)
    for home, some in missing.items():
        yield _missing(home, some)
    for (of, words), count in unread.items():
        yield Finding(NOTE, "document", f"{count_of(count, 'mesh', 'meshes')}{of} {'was' if count == 1 else 'were'} {words}")


def _reader() -> tuple[ModuleType | None, str]:
    """What reads meshes; or None, and what to install."""
    try:
        return mesh_reader(), ""
    except MissingExtraError as error:
        return None, str(error)


def _content_findings(
    uri: str, files: MeshFiles, reader: ModuleType, scale: tuple[float, ...], mesh: etree._Element
) -> Iterator[Finding]:
    name = f"mesh {_short(uri)}"
    try:
        path = files.find(uri)
        extents = np.ptp(reader.used_points(reader.read_scene(path, reader.mesh_bytes(path))), axis=0)
    except FileError as error:
        yield found(WARNING, mesh, f"{name} cannot be read: {error.message.removeprefix('cannot be read: ')}")
        return
    yield from _size_findings(name, np.abs(extents * scale).tolist(), mesh)


def _missing(home: str, some: list[tuple[str, etree._Element, tuple[str, ...]]]) -> Finding:
    """One finding for all missing meshes of a package or a folder, with every path tried for the first."""
    uri, mesh, tried = some[0]
    found_none = "not found" if tried else f"not found, as {uri[:80]!r} leads nowhere"
    count = f"{len(some)} mesh{'es' * (len(some) > 1)}"
    message = f"{count} of {home} {found_none}: {listed([_short(each) for each, _, _ in some])}"
    return Finding(WARNING, of_robot(mesh) if len(some) == 1 else "document", message, mesh.sourceline, tried)


def _home(uri: str) -> str:
    scheme, separator, rest = uri.partition("://")
    if scheme == "package" and separator:
        return f"package {rest.partition('/')[0]!r}"
    return f"folder {uri.rpartition('/')[0] or '.'!r}"


def _short(uri: str) -> str:
    return uri.rpartition("/")[2]
