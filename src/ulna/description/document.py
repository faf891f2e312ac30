"""A document of a description: read from a path or a text, and expanded if it is xacro."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from lxml import etree

from ulna.description.file_bytes import file_bytes
from ulna.description.xml import LONGEST, parse
from ulna.errors import FileError, InputError

NAMESPACES = ("http://www.ros.org/wiki/xacro", "http://ros.org/wiki/xacro", "http://wiki.ros.org/xacro")
"""Those of xacro."""


@dataclass(frozen=True)
class Document:
    """Text, its name in messages, its folder (None for text that was passed as such), folders of packages, its file's name."""

    text: bytes
    source: str
    folder: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    file: str = ""

    @cached_property
    def root(self) -> etree._Element:
        """Its root element, parsed once."""
        return parse(self.text, self.source)


def is_text(source: str) -> bool:
    """Whether a string is a document, not a path."""
    return source.lstrip("\ufeff \t\r\n").startswith("<")


def open_document(argument: str, source: str | Path, kind: str, package_dirs: tuple[Path, ...]) -> Document:
    """The document at a path, or in a string that begins with ``<``. ``argument`` and ``kind`` name it in messages."""
    if isinstance(source, str) and is_text(source):
        return Document(_encoded(argument, source), f"{kind} text", None, package_dirs)
    path = Path(source)
    try:
        text = file_bytes(path, LONGEST)  # one that is too long is refused when parsed
        return Document(text, path.name, path.parent, package_dirs, path.name)
    except FileNotFoundError:
        raise FileError(str(path), "no such file") from None
    except (OSError, ValueError) as error:
        raise FileError(str(path), getattr(error, "strerror", None) or str(error)) from None


def is_xacro(root: etree._Element) -> bool:
    """True if a document uses xacro: elements of its namespace, or its expressions with the namespace declared."""
    if any(isinstance(e.tag, str) and etree.QName(e).namespace in NAMESPACES for e in root.iter()):
        return True
    declared = any(uri in NAMESPACES for uri in root.nsmap.values())
    return declared and any("${" in str(v) or "$(" in str(v) for e in root.iter() for v in e.attrib.values())


def expanded(document: Document, xacro_args: Mapping[str, object], max_seconds: float = math.inf) -> Document:
    """The expansion of a xacro file, in so many seconds at most; any other document itself, which takes no arguments."""
    if not is_xacro(document.root):
        refuse_arguments(document.source, xacro_args)
        return document
    from ulna.description.xacro.expansion import expand_xacro  # noqa: PLC0415 - plain URDF needs no child process

    text = expand_xacro(document, xacro_args, max_seconds)
    return replace(document, text=text, source=f"{document.source} (expanded; `ulna urdf` prints it)")


def refuse_arguments(source: str, xacro_args: Mapping[str, object]) -> None:
    """Refuse arguments for a document that takes none."""
    if xacro_args:
        raise InputError("xacro_args", f"{source} is not a xacro file, so it takes no arguments")


def _encoded(argument: str, source: str) -> bytes:
    """Text as UTF-8, without an encoding that it may declare, and without what comes before an XML declaration."""
    text = source.lstrip("\ufeff")
    if text.lstrip().startswith("<?xml"):
        text = re.sub(r"""\s+encoding=(["'])[^"']*\1""", "", text.lstrip(), count=1)
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        raise InputError(argument, f"text that is not Unicode ({error})") from None
