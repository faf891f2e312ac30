"""Checks links: shapes without volume, missing, or of a size that suggests another unit; and inertia."""

from collections.abc import Iterator, Sequence

import numpy as np
from lxml import etree

from ulna.errors import listed
from ulna.inspection.elements import number, numbers, of_robot
from ulna.inspection.result import Finding, Severity

LARGEST, LEAST = 20.0, 1e-3  # m: what is larger or smaller than any part of an arm, and common in another unit
_ZERO = 1e-12  # relative to the largest moment
_ROUNDING = 1e-3  # relative: published inertias have three digits


def shape_findings(root: etree._Element) -> Iterator[Finding]:
    """What is wrong with boxes, spheres, cylinders and capsules, and which links have no shapes."""
    for kind in ("visual", "collision"):
        for element in root.iterfind(f"link/{kind}"):
            geometry = element.find("geometry")
            if geometry is None or not len(geometry):
                yield Finding(Severity.ERROR, of_robot(element), f"<{kind}> has no <geometry>", element.sourceline)
                continue
            yield from _primitive_findings(geometry[0], kind)
        yield from _without(root, kind)


def _primitive_findings(shape: etree._Element, kind: str) -> Iterator[Finding]:
    extents = _extents(shape)
    if extents is None:
        return
    where = of_robot(shape)
    if min(extents) < 0:
        yield Finding(Severity.ERROR, where, f"{kind} {shape.tag} has a negative length", shape.sourceline)
    elif min(extents) == 0:
        severity = Severity.WARNING if kind == "collision" else Severity.NOTE
        yield Finding(severity, where, f"{kind} {shape.tag} has no volume", shape.sourceline)
    else:
        yield from size_findings(f"{kind} {shape.tag}", extents, where, shape.sourceline)


def size_findings(what: str, extents: Sequence[float], where: str, line: int | None) -> Iterator[Finding]:
    """A warning if the extents [m] are those of no part of a robot."""
    largest = max(extents)
    words = " x ".join(f"{extent:.3g}" for extent in extents)
    if largest > LARGEST:
        yield Finding(Severity.WARNING, where, f"{what} is {words} m: millimetres? Lengths are metres", line)
    elif 0 < largest < LEAST:
        yield Finding(Severity.WARNING, where, f"{what} is {words} m: smaller than a millimetre; scaled twice?", line)


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
        yield Finding(Severity.NOTE, "document", f"no link has a {kind} shape")
        return
    other = "collision" if kind == "visual" else "visual"
    names = [link.get("name", "") for link in bare if link.find(other) is not None]
    if names:
        yield Finding(Severity.NOTE, "document", f"a {other} shape and no {kind} shape: {listed(names)}")


def inertia_findings(root: etree._Element) -> Iterator[Finding]:
    """Masses that are not positive, and inertias that are not positive definite or break the triangle inequality."""
    massless: list[str] = []
    for link in root.iterfind("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        where, line = of_robot(link), inertial.sourceline
        mass, moments = number(inertial.find("mass"), "value"), _principal_moments(inertial.find("inertia"))
        if mass == 0 and moments is not None and not moments.any():
            massless.append(link.get("name", ""))
            continue
        if mass is None or mass <= 0:
            yield Finding(Severity.WARNING, where, "mass is missing" if mass is None else f"mass is {mass:g} kg", line)
        if moments is None:
            yield Finding(Severity.WARNING, where, "inertia is missing, or not six numbers", line)
        elif not moments.any():
            yield Finding(Severity.WARNING, where, "inertia is zero", line)
        elif moments[0] <= _ZERO * moments[2]:
            least = "0" if abs(moments[0]) <= _ZERO * moments[2] else f"{moments[0]:.3g}"
            yield Finding(Severity.WARNING, where, f"inertia is not positive definite: a moment of {least}", line)
        elif moments[0] + moments[1] < moments[2] * (1 - _ROUNDING):
            message = f"inertia of no body: moments {moments[0]:.3g} + {moments[1]:.3g} < {moments[2]:.3g}"
            yield Finding(Severity.WARNING, where, message, line)
    if massless:
        yield Finding(Severity.NOTE, "document", f"mass and inertia are zero: {listed(massless)}")


def _principal_moments(inertia: etree._Element | None) -> np.ndarray | None:
    """The eigenvalues, ascending."""
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    values = [number(inertia, key) for key in keys]
    if None in values:
        return None
    xx, xy, xz, yy, yz, zz = values
    return np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64))
