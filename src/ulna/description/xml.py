"""Parses XML with limits on entities, network and depth; reads children, attributes and numbers of its elements."""

import math
import re

from lxml import etree

from ulna.errors import DescriptionError, cited

LONGEST = 64_000_000  # bytes; the largest of the robots in docs/robots.md has a hundredth of this
MOST_ELEMENTS = 300_000  # some 75 000 links: seconds, and a few hundred megabytes


def parse(text: bytes, source: str) -> etree._Element:
    """The root element of a document."""
    if len(text) > LONGEST:
        raise DescriptionError(f"is {len(text) / 1e6:.0f} MB long; up to {LONGEST / 1e6:.0f} MB are read", source)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False, remove_comments=True, remove_pis=True
    )
    if b"<!ENTITY" in text:
        raise DescriptionError("declares XML entities, which a robot description does not need; they are refused", source)
    try:
        root = etree.fromstring(text, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        line, message = getattr(error, "lineno", None), str(getattr(error, "msg", error))
        message = re.split(r",? (?:use|try) XML_PARSE", message, maxsplit=1)[0]
        message = re.sub(r"\s*, line \d+, column \d+$", "", " ".join(message.split()))
        raise DescriptionError(f"not XML: {message}", source, line) from None
    count = sum(1 for _ in root.iter())
    if count > MOST_ELEMENTS:
        raise DescriptionError(f"has {count} elements; up to {MOST_ELEMENTS} are read", source)
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and dtd.entities():  # pyright: ignore[reportAttributeAccessIssue]
        raise DescriptionError("declares XML entities, which a robot description does not need; they are refused", source)
    return root


def without_namespace(root: etree._Element) -> etree._Element:
    """The document with plain names for the elements of its root's namespace, which some generators declare."""
    prefix = f"{{{etree.QName(root).namespace}}}"
    if etree.QName(root).namespace is not None:
        for element in root.iter(f"{prefix}*"):
            element.tag = str(element.tag).removeprefix(prefix)
    return root


class Reader:
    """Reads the elements of one document, whose name, ``source``, is in every message."""

    def __init__(self, source: str) -> None:
        self.source = source

    def fail(self, element: etree._Element, message: str) -> DescriptionError:
        """An error with the line of an element."""
        return DescriptionError(message, self.source, element.sourceline)

    def child(self, element: etree._Element, tag: str) -> etree._Element:
        """The child of that tag."""
        child = self.only(element, tag)
        if child is None:
            raise self.fail(element, f"<{element.tag}> {element.get('name')!r} has no <{tag}>")
        return child

    def only(self, element: etree._Element, tag: str) -> etree._Element | None:
        """The child of that tag, or None."""
        children = element.findall(tag)
        if len(children) > 1:
            name = "".join(f" {value!r}" for value in [element.get("name")] if value)
            raise self.fail(children[1], f"<{element.tag}>{name} has {len(children)} <{tag}>; one is expected")
        return children[0] if children else None

    def attribute(self, element: etree._Element, key: str) -> str:
        """An attribute that must be there."""
        value = element.get(key)
        if not value:
            raise self.fail(element, f"<{element.tag}> has no attribute {key!r}")
        return value

    def number(self, element: etree._Element, key: str, default: float | None = None, low: float = -math.inf) -> float:
        """An attribute that is one finite number of at least ``low``; ``default`` if it is missing."""
        if default is not None and key not in element.attrib:
            return default
        return self.vector(element, key, 1, low)[0]

    def triple(self, element: etree._Element, key: str, low: float = -math.inf) -> tuple[float, float, float]:
        """An attribute that is three finite numbers of at least ``low``."""
        x, y, z = self.vector(element, key, 3, low)
        return x, y, z

    def vector(self, element: etree._Element, key: str, count: int, low: float = -math.inf) -> tuple[float, ...]:
        """An attribute that is ``count`` finite numbers of at least ``low``."""
        text, values = self.attribute(element, key), self.numbers(element, key)
        if len(values) != count or not all(math.isfinite(v) and v >= low for v in values):
            expected = f"{count} finite number{'s' * (count > 1)}" + (f" of at least {low:g}" if low > -math.inf else "")
            raise self.fail(element, f"<{element.tag}> {key}={cited(text)}: {expected} expected")
        return values

    def numbers(self, element: etree._Element, key: str) -> tuple[float, ...]:
        """An attribute that is any count of numbers, which may be infinite or NaN."""
        text = self.attribute(element, key)
        try:
            if "_" in text or not text.isascii():
                raise ValueError  # noqa: TRY301
            return tuple(float(word) for word in text.split())
        except ValueError:
            hint = " (an expression: is this a xacro file without its xmlns:xacro?)" if "${" in text else ""
            raise self.fail(element, f"<{element.tag}> {key}={cited(text)}: not numbers{hint}") from None
