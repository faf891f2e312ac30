"""A document of a description: read from a path or a text, and expanded if it is xacro."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ulna.description.file_bytes import file_bytes
from ulna.description.xacro.expansion import expand_xacro, is_xacro
from ulna.description.xml import LONGEST, parse
from ulna.errors import FileError, InputError


@dataclass(frozen=True)
class Document:
    """Text, its name in messages, its folder (None for text that was passed as such), folders of packages, its file's name."""

    text: bytes
    source: str
    folder: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    file: str = ""


def is_text(source: str) -> bool:
    """Whether a string is a document, not a path."""
    return source.lstrip("\ufeff \t\r\n").startswith("<")


def open_document(argument: str, source: str | Path, kind: str) -> Document:
    """The document at a path, or in a string that begins with ``<``. ``argument`` and ``kind`` name it in messages.

    Raises:
        FileError: The file cannot be read.
    """
    if isinstance(source, str) and is_text(source):
        return Document(_encoded(argument, source), f"{kind} text")
    path = Path(source)
    try:
        return Document(
            file_bytes(path, LONGEST), path.name, path.parent, file=path.name
        )  # one that is too long is refused when parsed
    except FileNotFoundError:
        raise FileError(str(path), "no such file") from None
    except (OSError, ValueError) as error:
        raise FileError(str(path), getattr(error, "strerror", None) or str(error)) from None


def expanded(document: Document, xacro_args: Mapping[str, object], package_dirs: tuple[Path, ...]) -> Document:
    """What a xacro file expands to; any other document as it is, which takes no arguments. It holds the ``package_dirs``.

    Raises:
        DescriptionError: The document is not XML, or cannot be expanded.
        InputError: It takes no arguments, or has none of a given name.
    """
    if is_xacro(parse(document.text, document.source)):
        text = expand_xacro(document.text, document.source, document.folder, xacro_args, package_dirs)
        source = f"{document.source} (expanded; `ulna urdf` prints it)"
        return replace(document, text=text, source=source, package_dirs=package_dirs)
    refuse_arguments(document.source, xacro_args)
    return replace(document, package_dirs=package_dirs)


def refuse_arguments(source: str, xacro_args: Mapping[str, object]) -> None:
    """Refuse arguments for a document that takes none.

    Raises:
        InputError: There are arguments.
    """
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
