"""Lists unused elements and invalid numbers of a description (wiki.ros.org/urdf/XML)."""

import math
from collections import Counter
from collections.abc import Iterator

from lxml import etree

from ulna.description.unread import ATTRIBUTES, CHILDREN, RATES, RATES_SINCE, of_robot, unread_parts, version_of
from ulna.inspection.result import ERROR, NOTE, WARNING, Finding, Severity

_WORDS = {"name", "type", "version", "link", "joint", "filename"}
_COUNTS = {"xyz": 3, "rpy": 3, "quat_xyzw": 4, "size": 3, "scale": 3, "rgba": 4}


def finding_at(severity: Severity, element: etree._Element, message: str) -> Finding:
    """A finding about the joint, link or document that contains an element, at the element's line."""
    return Finding(severity, of_robot(element), message, element.sourceline)


def numbers(element: etree._Element | None, key: str) -> tuple[float, ...] | None:
    """The finite numbers of an attribute; None if one is invalid or their count is wrong."""
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
    """Findings about invalid numbers, names that are probably misspelt, and elements that are not read."""
    unused: Counter[str] = Counter()
    others = RATES if (version_of(root) or (1, 0)) < RATES_SINCE else ()  # reported as unread
    for element in root.iter(*ATTRIBUTES):
        if all(str(one.tag) in CHILDREN for one in element.iterancestors()):
            yield from _number_findings(element, others)
    for part in unread_parts(root):
        if part.message:
            yield finding_at(WARNING, part.element, part.message)
        else:
            unused[part.what] += 1
    for what, count in unused.items():
        yield Finding(NOTE, "document", f"{count} {what} not used")


def _number_findings(element: etree._Element, others: tuple[str, ...]) -> Iterator[Finding]:
    for key, text in ((str(key), str(value)) for key, value in element.attrib.items()):
        if key in ATTRIBUTES[str(element.tag)] and key not in (*_WORDS, *others) and numbers(element, key) is None:
            count = _COUNTS.get(key, 1)
            message = f'<{element.tag}> {key}="{text[:60]}": {count} finite number{"s" * (count > 1)} expected'
            yield finding_at(ERROR, element, message)
