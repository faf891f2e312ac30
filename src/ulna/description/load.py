"""Loads a description by a bundled name, a path, text, or the name of a robot elsewhere; expands it if it is xacro."""

import re
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ulna.description.file_bytes import file_bytes
from ulna.description.meshes.mesh_files import with_mesh_paths
from ulna.description.names.by_name import BUNDLED, find_by_name
from ulna.description.packages import as_package_dirs
from ulna.description.references import matched
from ulna.description.robot_description import Description
from ulna.description.srdf import read_srdf
from ulna.description.urdf import decoded, read_urdf
from ulna.description.xacro.expansion import expand_xacro, is_xacro
from ulna.description.xml import LONGEST, parse
from ulna.errors import DescriptionWarning, FileError, InputError


@dataclass(frozen=True)
class Document:
    """Text, its name in messages, its folder (None for text that was passed as such), and the folders of packages."""

    text: bytes
    source: str
    folder: Path | None = None
    package_dirs: tuple[Path, ...] = ()


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
        return Document(file_bytes(path, LONGEST), path.name, path.parent)  # one that is too long is refused when parsed
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
        return Document(text, f"{document.source} (expanded; `ulna urdf` prints it)", document.folder, package_dirs)
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


_SUFFIXES = (".urdf", ".xacro", ".srdf", ".xml", ".sdf", ".mjcf")
_LONGEST_NAME = 100
Home = tuple[float, ...] | None


def load_description(
    source: str | Path,
    xacro_args: Mapping[str, object],
    package_dirs: Iterable[str | Path],
    srdf: str | Path | None = None,
) -> tuple[Description, Home]:
    """The description, and for a bundled robot its home configuration.

    Raises:
        FileError: A file cannot be read, or there is no robot of that name.
        DescriptionError: The description is invalid; the message names the file and, if known, the line.
        InputError: ``source`` or ``srdf`` is neither a path nor text, or the document has no such xacro argument.
    """
    document, home = _document(source, xacro_args, package_dirs)
    description = replace(read_urdf(document.text, document.source), folder=document.folder, package_dirs=document.package_dirs)
    if srdf is None and isinstance(source, str) and source in BUNDLED:
        srdf = BUNDLED[source].semantics()
    if srdf is None:
        return description, home
    _check_source("srdf", srdf, "a path or SRDF text")
    semantic = expanded(open_document("srdf", srdf, "SRDF"), {}, document.package_dirs)
    semantics = matched(read_srdf(semantic.text, semantic.source), description)
    for first in semantics.warnings[:1]:
        count = len(semantics.warnings)
        more = f" ({count} such sentences: robot.srdf.warnings)" if count > 1 else ""
        warnings.warn(first + more, DescriptionWarning, stacklevel=3)
    return replace(description, srdf=semantics), home


def urdf_text(
    source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path], mesh_paths: str = "given"
) -> str:
    """The URDF text of a source, even if it cannot be loaded; of a xacro file, its expansion."""
    document, _ = _document(source, xacro_args, package_dirs)
    text = decoded(parse(document.text, document.source), document.text, document.source)
    return with_mesh_paths(mesh_paths, text, document.folder, document.package_dirs)


def _document(source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]) -> tuple[Document, Home]:
    _check_source("source", source, "a name, a path or URDF text")
    if not isinstance(xacro_args, Mapping):
        raise InputError("xacro_args", f"{xacro_args!r}; a dict of names and values is expected")
    folders = as_package_dirs(package_dirs)
    if isinstance(source, str) and source in BUNDLED:
        bundled = BUNDLED[source]
        refuse_arguments(source, xacro_args)
        return Document(bundled.text(), bundled.file, package_dirs=folders), bundled.home
    if isinstance(source, str) and not is_text(source) and _may_be_a_name(source):
        named = find_by_name(source)
        source, xacro_args, folders = named.path, {**named.xacro_args, **xacro_args}, (*folders, *named.package_dirs)
    return expanded(open_document("source", source, "URDF"), xacro_args, folders), None


def _may_be_a_name(source: str) -> bool:
    """Whether it does not look like a path, and there is no file of that name."""
    path = Path(source)
    try:
        return path.name == source and path.suffix not in _SUFFIXES and len(source) < _LONGEST_NAME and not path.exists()
    except (OSError, ValueError):  # too long for a path, or with a character that no path has
        return False


def _check_source(argument: str, source: object, expected: str) -> None:
    if not isinstance(source, (str, Path)):
        raise InputError(argument, f"{type(source).__name__}; {expected} is expected")
    if isinstance(source, str) and not source.strip():
        raise InputError(argument, f"an empty string; {expected} is expected")
