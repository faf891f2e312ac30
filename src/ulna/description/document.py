"""Reads the document of a description from a path or a text, and expands it if it is xacro."""

import math
import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from lxml import etree

from ulna.description.file_bytes import file_bytes
from ulna.description.xml import LONGEST, XACRO_NAMESPACE, Parsed, parse_leniently
from ulna.errors import DescriptionWarning, FileError, InputError, reason_of

NAMESPACES = (XACRO_NAMESPACE, "http://ros.org/wiki/xacro", "http://wiki.ros.org/xacro")
"""The namespaces of xacro."""
_NOT_MACROS = {"macro", "property", "arg", "include", "if", "unless", "insert_block", "call", "element", "attribute", "eval"}


@dataclass(frozen=True)
class Document:
    """A text with its name in messages, its folder (None if passed as text), package folders and file name."""

    text: bytes
    source: str
    folder: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    file: str = ""

    @cached_property
    def root(self) -> etree._Element:
        """Its root element, parsed once."""
        return self.parsed.root

    @cached_property
    def parsed(self) -> Parsed:
        """Its root element with its text, repaired if its XML is not well-formed."""
        return parse_leniently(self.text, self.source)


def is_text(source: str) -> bool:
    """Whether a string is a document, not a path."""
    return source.lstrip("\ufeff \t\r\n").startswith("<")


def open_document(argument: str, source: str | Path, kind: str, package_dirs: tuple[Path, ...]) -> Document:
    """Open the document at a path, or in a string beginning with ``<``; ``argument`` and ``kind`` name it in messages."""
    if isinstance(source, str) and is_text(source):
        return Document(_encoded(argument, source), f"{kind} text", None, package_dirs)
    path = Path(source)
    try:
        text = file_bytes(path, LONGEST)  # a text that is too long is refused by the parser
        return Document(text, path.name, path.parent, package_dirs, path.name)
    except (OSError, ValueError) as error:
        raise FileError(str(path), reason_of(error)) from None


def is_xacro(root: etree._Element) -> bool:
    """Whether a document uses xacro: its elements, or its expressions with the namespace declared."""
    if next(xacro_elements(root), None) is not None:
        return True
    return any(uri in NAMESPACES for uri in root.nsmap.values()) and _computes(root)


def xacro_elements(root: etree._Element) -> Iterator[etree._Element]:
    """The elements of xacro's namespaces."""
    return root.iter(*(f"{{{uri}}}*" for uri in NAMESPACES))


def _is_expanded(root: etree._Element) -> bool:
    """Whether a document is the result of an expansion: it has links, and of xacro at most calls of macros."""
    names = {etree.QName(e).localname for e in xacro_elements(root)}
    return names.isdisjoint(_NOT_MACROS) and root.find("link") is not None and not _computes(root)


def _computes(root: etree._Element) -> bool:
    """Whether an attribute contains an expression or a substitution of xacro."""
    return any("${" in str(v) or "$(" in str(v) for e in root.iter() for v in e.attrib.values())


def expanded(document: Document, xacro_args: Mapping[str, object], max_seconds: float = math.inf) -> Document:
    """Expand a xacro file within a time limit; any other document is returned unchanged, and takes no arguments.

    A document with links that only calls macros, and is not named ``.xacro``, is the result of an expansion, and is returned too.
    """
    root = document.root
    if not is_xacro(root) or (not document.file.endswith(".xacro") and _is_expanded(root)):
        warn_of_arguments(document.source, xacro_args)
        return document
    from ulna.description.xacro.expansion import expand_xacro  # noqa: PLC0415 - plain URDF needs no child process

    text = expand_xacro(document, xacro_args, max_seconds)
    return replace(document, text=text, source=f"{document.source} (expanded; `ulna urdf` prints it)")


def shared_arguments(document: Document, xacro_args: Mapping[str, object]) -> dict[str, object]:
    """The arguments that a document defines: an SRDF defines some of its URDF's."""
    defined = {e.get("name") for e in document.root.iter() if isinstance(e.tag, str) and etree.QName(e).localname == "arg"}
    return {name: value for name, value in xacro_args.items() if name in defined}


def warn_of_arguments(source: str, xacro_args: Mapping[str, object]) -> None:
    """Warn of arguments for a document that takes none; in a comparison they may be for the other document."""
    if xacro_args:
        names = ", ".join(map(repr, xacro_args))
        sentence = f"{source} is not a xacro file, so it takes no arguments: {names} of xacro_args have no effect"
        warnings.warn(sentence, DescriptionWarning, stacklevel=6)


def _encoded(argument: str, source: str) -> bytes:
    """Encode text as UTF-8, without a declared encoding, and without text before an XML declaration."""
    text = source.lstrip("\ufeff")
    if text.lstrip().startswith("<?xml"):
        text = re.sub(r"""\s+encoding=(["'])[^"']*\1""", "", text.lstrip(), count=1)
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        raise InputError(argument, f"text that is not Unicode ({error})") from None
