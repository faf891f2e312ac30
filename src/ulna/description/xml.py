"""Parses XML with limits on entities, network and depth; reads children, attributes and numbers of its elements."""

import math
import re
from typing import NamedTuple

from lxml import etree

from ulna.errors import DescriptionError, cited

LONGEST = 64_000_000  # bytes; the largest of the robots in docs/robots.md has a hundredth of this
MAX_ELEMENTS = 300_000  # about 75 000 links: seconds, and a few hundred megabytes
_BEFORE = rb"(?>\s+|<!--(?>.*?-->))*+"  # allowed before the root, but not before a declaration
_DECLARATION = re.compile(rb"\A(?:\xef\xbb\xbf)?(" + _BEFORE + rb")<\?xml\b([^>]{0,200})>", re.DOTALL)
_ROOT = re.compile(_BEFORE + rb"(?:<\?(?>.*?\?>)" + _BEFORE + rb")?(?:<![^\[>]*>" + _BEFORE + rb")?<[\w.:-]+", re.DOTALL)
_PREFIX = re.compile(r"Namespace prefix (\S+) ")
_MAX_PREFIXES = 100
XACRO_NAMESPACE = "http://www.ros.org/wiki/xacro"


class Parsed(NamedTuple):
    """A parsed document.

    Attributes:
        root: Its root element.
        text: Its text, well-formed.
        mended: Its fault if it was not well-formed; empty otherwise.
    """

    root: etree._Element
    text: bytes
    mended: str = ""


def parse(text: bytes, source: str) -> etree._Element:
    """The root element of a document."""
    return parse_leniently(text, source).root


def parse_leniently(text: bytes, source: str) -> Parsed:
    """The root of a document, even with a faulty XML declaration or undeclared prefixes, as other parsers read.

    A repair changes no element and no line: urdfdom, MuJoCo and PyBullet ignore a version, blanks before a declaration, missing
    quotes in it, and namespaces.
    """
    if len(text) > LONGEST:
        raise DescriptionError(f"is {len(text) / 1e6:.0f} MB long; up to {LONGEST / 1e6:.0f} MB are read", source)
    if b"<!ENTITY" in text:
        raise DescriptionError("declares XML entities, which a robot description does not need; they are refused", source)
    mended, faults = text, []
    for mend in (_with_declaration, _with_prefixes, None):
        parser = _parser()
        try:
            root = etree.fromstring(mended, parser)
        except (etree.XMLSyntaxError, ValueError) as error:
            line, message = getattr(error, "lineno", None), _message_of(error)
            faults.append(message)
            if mend is None:
                raise DescriptionError(f"not XML: {message}", source, line) from None
            mended = mend(mended, list(parser.error_log))  # the error's own log includes errors of other documents
        else:
            _check_size(root, source)
            return Parsed(root, mended, "" if mended is text else faults[0])
    raise AssertionError("the last one returns or raises")


def _parser() -> etree.XMLParser:
    return etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False, remove_comments=True, remove_pis=True
    )


def _message_of(error: Exception) -> str:
    message = re.split(r",? (?:use|try) XML_PARSE", str(getattr(error, "msg", error)), maxsplit=1)[0]
    return re.sub(r"\s*, line \d+, column \d+$", "", " ".join(message.split()))


def _with_declaration(text: bytes, _log: list) -> bytes:
    """The text with a correct XML declaration at its start, replacing a faulty or misplaced one."""
    declared = _DECLARATION.match(text)
    if declared is None:
        return text
    encoding = re.search(rb"""encoding\s*=\s*["']?([A-Za-z][\w.-]*)""", declared[2])
    stated = b"" if encoding is None else b' encoding="%s"' % encoding[1]
    lines = b"\n" * declared[2].count(b"\n")
    return b'<?xml version="1.0"%s?>' % stated + declared[1] + lines + text[declared.end() :]


def _with_prefixes(text: bytes, log: list) -> bytes:
    """The text with its undeclared prefixes declared in the root, if the parser's log shows no other faults."""
    found = [_PREFIX.match(one.message) for one in log if one.type_name == "NS_ERR_UNDEFINED_NAMESPACE"]
    prefixes = dict.fromkeys(one[1] for one in found if one is not None)
    root = _ROOT.match(text.removeprefix(b"\xef\xbb\xbf"))
    if not prefixes or len(found) < len(log) or len(prefixes) > _MAX_PREFIXES or root is None:
        return text
    uris = {prefix: XACRO_NAMESPACE if prefix == "xacro" else f"undeclared:{prefix}" for prefix in prefixes}
    declared = "".join(f' xmlns:{prefix}="{uri}"' for prefix, uri in uris.items()).encode()
    end = root.end() + len(text) - len(text.removeprefix(b"\xef\xbb\xbf"))
    return text[:end] + declared + text[end:]


def _check_size(root: etree._Element, source: str) -> None:
    """Refuse too many elements, and entities that another encoding hides in the text."""
    count = sum(1 for _ in root.iter())
    if count > MAX_ELEMENTS:
        raise DescriptionError(f"has {count} elements; up to {MAX_ELEMENTS} are read", source)
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and dtd.entities():  # pyright: ignore[reportAttributeAccessIssue]
        raise DescriptionError("declares XML entities, which a robot description does not need; they are refused", source)


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
        """The required child with a tag."""
        child = self.only(element, tag)
        if child is None:
            raise self.fail(element, f"<{element.tag}>{self._name_of(element)} has no <{tag}>")
        return child

    def only(self, element: etree._Element, tag: str) -> etree._Element | None:
        """The child with a tag, or None."""
        children = element.findall(tag)
        if len(children) > 1:
            message = f"<{element.tag}>{self._name_of(element)} has {len(children)} <{tag}>; one is expected"
            raise self.fail(children[1], message)
        return children[0] if children else None

    def _name_of(self, element: etree._Element) -> str:
        return "".join(f" {value!r}" for value in [element.get("name")] if value)

    def attribute(self, element: etree._Element, key: str) -> str:
        """A required attribute."""
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
        return self.finite(element, self.attribute(element, key), count, low, f" {key}=")

    def numbers(self, element: etree._Element, key: str) -> tuple[float, ...]:
        """An attribute that is any count of numbers, which may be infinite or NaN."""
        return self.parsed(element, self.attribute(element, key), f" {key}=")

    def finite(self, element: etree._Element, text: str, count: int, low: float, where: str = " ") -> tuple[float, ...]:
        """A text that is ``count`` finite numbers of at least ``low``; ``where`` locates it in an element."""
        values = self.parsed(element, text, where)
        if len(values) != count or not all(math.isfinite(v) and v >= low for v in values):
            expected = f"{count} finite number{'s' * (count > 1)}" + (f" of at least {low:g}" if low > -math.inf else "")
            raise self.fail(element, f"<{element.tag}>{where}{cited(text)}: {expected} expected")
        return values

    def parsed(self, element: etree._Element, text: str, where: str = " ") -> tuple[float, ...]:
        """A text that is any count of numbers, which may be infinite or NaN."""
        try:
            if "_" in text or not text.isascii():
                raise ValueError  # noqa: TRY301
            return tuple(float(word) for word in text.split())
        except ValueError:
            hint = " (an expression: is this a xacro file without its xmlns:xacro?)" if "${" in text else ""
            raise self.fail(element, f"<{element.tag}>{where}{cited(text)}: not numbers{hint}") from None
