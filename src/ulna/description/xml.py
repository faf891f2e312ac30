"""Parses XML with limits: no entities, no network, no unlimited depth."""

import re

from lxml import etree

from ulna.errors import DescriptionError

LONGEST = 64_000_000  # bytes; the largest of the robots in docs/robots.md has a hundredth of this
MOST_ELEMENTS = 300_000  # some 75 000 links: seconds, and a few hundred megabytes


def parse(text: bytes, source: str) -> etree._Element:
    """The root element of a document.

    Raises:
        DescriptionError: It is not XML, or too long, or declares entities (a few lines of which can expand to gigabytes).
    """
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
        message = message.split(", use XML_PARSE", maxsplit=1)[0].split(", try XML_PARSE", maxsplit=1)[0]
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
