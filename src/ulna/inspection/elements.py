"""Finds the elements and numbers of a description that are used (wiki.ros.org/urdf/XML)."""

import difflib
import math
from collections import Counter
from collections.abc import Iterable, Iterator

from lxml import etree

from ulna.inspection.result import ERROR, NOTE, WARNING, Finding, Severity

# For each element the children and the attributes that are used, or looked at here.
_CHILDREN = {
    "robot": ("link", "joint", "material"),
    "link": ("visual", "collision", "inertial"),
    "joint": ("parent", "child", "origin", "axis", "limit", "mimic", "safety_controller"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "inertial": ("origin", "mass", "inertia"),
    "geometry": ("box", "sphere", "cylinder", "capsule", "mesh"),
    "material": ("color",),
}
_ATTRIBUTES = {
    "robot": ("name", "version"),
    "link": ("name",),
    "visual": ("name",),
    "collision": ("name",),
    "material": ("name",),
    "joint": ("name", "type"),
    "parent": ("link",),
    "child": ("link",),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort"),
    "mimic": ("joint", "multiplier", "offset"),
    "safety_controller": ("k_velocity", "k_position", "soft_lower_limit", "soft_upper_limit"),
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "mesh": ("filename", "scale"),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "color": ("rgba",),
}
_WORDS = {"name", "type", "version", "link", "joint", "filename"}
_LIKENESS = 0.8  # "efort" is meant to be "effort"; "gear_velocity" is something else
_COUNTS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "rgba": 4}


def of_robot(element: etree._Element) -> str:
    """The joint, link or document that an element belongs to, in words."""
    for one in (element, *element.iterancestors()):
        if one.tag in ("joint", "link"):
            return f"{one.tag} {one.get('name', '')!r}"
    return "document"


def found(severity: Severity, element: etree._Element, message: str) -> Finding:
    """A finding about the joint, the link or the document that an element belongs to, at the element's line."""
    return Finding(severity, of_robot(element), message, element.sourceline)


def numbers(element: etree._Element | None, key: str) -> tuple[float, ...] | None:
    """The finite numbers of an attribute, or None if there are none or not as many as it takes."""
    try:
        values = tuple(float(word) for word in (element.get(key) or "").split()) if element is not None else ()
    except ValueError:
        return None
    return values if len(values) == _COUNTS.get(key, 1) and all(map(math.isfinite, values)) else None


def number(element: etree._Element | None, key: str) -> float | None:
    """The finite number of an attribute, or None."""
    values = numbers(element, key)
    return None if values is None else values[0]


def element_findings(root: etree._Element) -> Iterator[Finding]:
    """What should be a number and is none, what is probably misspelt, and what is not used."""
    unused: Counter[str] = Counter()
    waiting = [root]
    while waiting:
        element = waiting.pop()
        if element.tag not in _CHILDREN and element.tag not in _ATTRIBUTES:
            continue
        yield from _attribute_findings(element, unused)
        used = _CHILDREN.get(str(element.tag), ())
        waiting.extend(child for child in element.iterchildren(etree.Element, reversed=True) if child.tag in used)
        for child in element.iterchildren(etree.Element):
            tag = etree.QName(child).localname
            if child.tag in used:
                continue
            if near := _nearly(tag, used):
                message = f"<{tag}> in <{element.tag}> is not known, and left out; did you mean <{near}>?"
                yield found(WARNING, child, message)
            else:
                unused[f"<{tag}> in <{element.tag}>"] += 1
    for what, count in unused.items():
        yield Finding(NOTE, "document", f"{count} {what} not used")


def _attribute_findings(element: etree._Element, unused: Counter[str]) -> Iterator[Finding]:
    known = _ATTRIBUTES.get(str(element.tag), ())
    for key, text in ((str(key), str(value)) for key, value in element.attrib.items()):
        if key in known and key not in _WORDS and numbers(element, key) is None:
            count = _COUNTS.get(key, 1)
            message = f'<{element.tag}> {key}="{text[:60]}": {count} finite number{"s" * (count > 1)} expected'
            yield found(ERROR, element, message)
        elif key not in known and (near := _nearly(key, known)):
            message = f"attribute {key!r} of <{element.tag}> is not known, and left out; did you mean {near!r}?"
            yield found(WARNING, element, message)
        elif key not in known and known and "}" not in key:
            unused[f"attribute {key!r} of <{element.tag}>"] += 1


def _nearly(name: str, known: Iterable[str]) -> str | None:
    """The known name that a misspelt one was meant to be."""
    return next(iter(difflib.get_close_matches(name, known, n=1, cutoff=_LIKENESS)), None)
