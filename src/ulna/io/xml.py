"""XML read with care: no entities, no network, no depth without end; every fault is a ``DescriptionError`` with its line."""

from lxml import etree

from ulna.errors import DescriptionError


def parse(text: bytes, source: str) -> etree._Element:
    """The root element of a document.

    Raises:
        DescriptionError: It is not XML, or it declares entities (a few lines of those can expand to gigabytes).
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False, remove_comments=True)
    if b"<!ENTITY" in text:
        raise DescriptionError("declares XML entities, which a robot description does not need; they are refused", source)
    try:
        root = etree.fromstring(text, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        raise DescriptionError(f"not XML: {getattr(error, 'msg', error)}", source, line) from None
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and dtd.entities():  # pyright: ignore[reportAttributeAccessIssue]
        raise DescriptionError("declares XML entities, which a robot description does not need; they are refused", source)
    return root
