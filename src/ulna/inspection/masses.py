"""Checks inertias: impossible tensors, mismatches with a link's shapes, masses in grams, and links without mass."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.inertias import ROUNDING
from ulna.description.robot_description import Description, Inertia, Joint, JointType, Link
from ulna.description.structure import joints_from_root
from ulna.description.urdf import inertia_of
from ulna.errors import DescriptionError, listed
from ulna.inspection.boxes import Boxes
from ulna.inspection.elements import finding_at
from ulna.inspection.result import NOTE, WARNING, Finding

_ZERO = 1e-12  # relative to the largest moment
_DENSEST = 30_000.0  # kg/m^3: no metal exceeds 22,600
_WIDEST = 1000.0  # factor on mass times squared size: a real body stays below 1, a placeholder below about 100
_MIN_SIZE, _MAX_SIZE = 0.02, 20.0  # m: smaller shapes mark frames, whose masses are placeholders; no link is larger
_HEAVIEST, _HEAVIEST_AT_REACH = 1000.0, 1000.0  # kg, and kg per squared reach: the largest arms have half of that


def inertia_findings(root: etree._Element, *, loads: bool) -> Iterator[Finding]:
    """Findings about masses of 0, and tensors that are not positive definite or violate the triangle inequality.

    In a document that loads, faulty inertias are left out, with findings of their own.
    """
    massless: list[str] = []
    for link in root.iterfind("link"):
        try:
            inertia = inertia_of(link)
        except DescriptionError as error:
            if not loads:
                yield Finding(WARNING, f"link {link.get('name', '')!r}", error.message, error.line)
            continue
        if inertia is None:
            continue
        if inertia.mass == 0 and not inertia.tensor.any():
            massless.append(link.get("name", ""))
        else:
            yield from (
                finding_at(WARNING, element, message) for element in link.iterfind("inertial") for message in _faults(inertia)
            )
    if massless:
        yield Finding(NOTE, "document", f"mass and inertia are zero: {listed(massless)}")


def _faults(inertia: Inertia) -> Iterator[str]:
    """Reasons why no body can have an inertia."""
    if inertia.mass == 0:
        yield "mass is 0 kg"
    least, middle, most = np.linalg.eigvalsh(inertia.tensor).tolist()
    if not inertia.tensor.any():
        yield "inertia is zero"
    elif least <= _ZERO * most:
        yield f"inertia is not positive definite: a moment of {0 if abs(least) <= _ZERO * most else least:.3g}"
    elif least + middle < most * (1 - ROUNDING):
        yield f"inertia of no real body: moments {least:.3g} + {middle:.3g} < {most:.3g}"


class _Part(NamedTuple):
    """The links that move as one: the joint that moves them, and whether another joint is attached to them."""

    joint: Joint
    links: list[Link]
    is_leaf: bool


def mass_findings(description: Description, boxes: Boxes, reach: float) -> Iterator[Finding]:
    """Findings about inertias that do not fit their links' shapes, masses that look like grams, and parts without mass."""
    dense: dict[Link, str] = {}
    wide: dict[Link, str] = {}
    for link in description.links:
        if link.inertia is None or not link.inertia.mass:
            continue
        box, moment = boxes.box_of_link(link), float(np.linalg.eigvalsh(link.inertia.tensor)[-1])
        extents = np.full(3, _MAX_SIZE) if box is None else np.maximum(box[1] - box[0], _MIN_SIZE)
        if (density := link.inertia.mass / float(extents.prod())) > _DENSEST:
            dense[link] = f"{density:.2g} kg/m^3"
        if moment > _WIDEST * link.inertia.mass * float(extents @ extents):
            wide[link] = f"{moment:.3g} kg m^2"
        if box is not None:
            yield from _far_center(link, link.inertia, box)
    yield from _joint_finding(dense, "denser than any metal", "Grams? Masses are in kilograms")
    yield from _joint_finding(wide, "moments of a body many times larger", "Are these g mm^2 or kg mm^2? Tensors are in kg m^2")
    total = sum(link.inertia.mass for link in description.links if link.inertia is not None)
    if total > max(_HEAVIEST, _HEAVIEST_AT_REACH * reach**2):
        yield Finding(WARNING, "document", f"the masses are {total:.4g} kg in sum: grams? Masses are in kilograms")
    if any(link.inertia is not None for link in description.links):
        yield from _without_mass(description)


def _joint_finding(links: dict[Link, str], what: str, question: str) -> Iterator[Finding]:
    """One finding for all links with the same question; a single link is named as the place."""
    if len(links) == 1:
        ((link, words),) = links.items()
        yield Finding(WARNING, f"link {link.name!r}", f"{what}, {words}. {question}", link.line)
    elif links:
        listing = listed([f"{link.name} ({words})" for link, words in links.items()])
        yield Finding(WARNING, "document", f"{what}: {listing}. {question}")


def _far_center(link: Link, inertia: Inertia, box: NDArray[np.float64]) -> Iterator[Finding]:
    """A finding if a center of mass is farther from its link's box, shape (2, 3), than the box's diagonal."""
    size = float(np.linalg.norm(box[1] - box[0]))
    apart = float(np.linalg.norm(inertia.center - np.clip(inertia.center, *box)))
    if apart > max(size, _MIN_SIZE):
        center = ", ".join(f"{x:.3g}" for x in inertia.center)
        message = f"its center of mass ({center}) is {apart:.3g} m off its shapes, which are {size:.3g} m across"
        yield Finding(WARNING, f"link {link.name!r}", f"{message}: in another frame, or in millimeters?", link.line)


def _without_mass(description: Description) -> Iterator[Finding]:
    """Findings about moving links with shapes, and ends of chains, without inertia; and parts with a mass of 0."""
    lacking: list[str] = []
    massless: dict[Link, str] = {}
    links = {link.name: link for link in description.links}
    for part in _parts(description, links):
        given = [link.inertia for link in part.links if link.inertia is not None]
        has_shapes = any(link.visuals or link.collisions for link in part.links)
        lacking += [link.name for link in part.links if link.inertia is None and (link.visuals or link.collisions)]
        if not given and not has_shapes and part.is_leaf:
            lacking.append(part.joint.child)
        if given and has_shapes and not any(inertia.mass or inertia.tensor.any() for inertia in given):
            massless[links[part.joint.child]] = f"by {part.joint.name}"
    yield from _joint_finding(massless, "has a mass of 0 kg and is moved", "No force can move such a part by itself")
    if lacking:
        yield Finding(WARNING, "document", f"moved, but without an inertia, which other links have: {listed(lacking)}")


def _parts(description: Description, links: dict[str, Link]) -> list[_Part]:
    """The parts that joints move, each with all links that move as one with it."""
    head: dict[str, str] = {}  # the moving link that carries each link
    movers: dict[str, Joint] = {}
    for joint in joints_from_root(description):
        above = head.get(joint.parent, "")
        head[joint.child] = above if joint.type == JointType.FIXED else joint.child
        if joint.type != JointType.FIXED:
            movers[joint.child] = joint
    carrying = {head.get(joint.parent, "") for joint in movers.values()}
    rigid: dict[str, list[Link]] = {name: [] for name in movers}
    for name, carrier in head.items():
        if carrier:
            rigid[carrier].append(links[name])
    return [_Part(joint, rigid[name], name not in carrying) for name, joint in movers.items()]
