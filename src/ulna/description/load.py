"""Loads a description by a bundled name, a path, text, or the name of a robot elsewhere, with its SRDF."""

import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal

from lxml import etree

from ulna.description.document import Document, expanded, is_text, open_document, shared_arguments, warn_of_arguments
from ulna.description.meshes.mesh_files import with_mesh_paths
from ulna.description.mjcf import read_mjcf
from ulna.description.names.arm_tables import ArmTable
from ulna.description.names.by_name import BUNDLED, Bundled, find_by_name
from ulna.description.packages import as_package_dirs
from ulna.description.references import matched
from ulna.description.robot_description import Description
from ulna.description.sdf.models import read_sdf
from ulna.description.semantic import Srdf
from ulna.description.srdf import read_srdf
from ulna.description.srdf_beside import srdf_beside
from ulna.description.unread import sentences
from ulna.description.urdf import decoded, read_urdf
from ulna.description.urdf_writer import write_urdf
from ulna.errors import DescriptionWarning, InputError

_SUFFIXES = (".urdf", ".xacro", ".srdf", ".xml", ".sdf", ".world", ".mjcf")
_LONGEST_NAME = 100
Home = tuple[float, ...] | None


def load_description(
    source: str | Path,
    xacro_args: Mapping[str, object],
    package_dirs: Iterable[str | Path],
    srdf: str | Path | Literal[False] | None = None,
) -> tuple[Description, Home]:
    """The description, and for a bundled robot its home configuration.

    Without ``srdf`` an SRDF next to the URDF is used (``srdf_beside``); False uses none.
    """
    document, bundled = _document(source, xacro_args, package_dirs)
    read = _other_format(document)
    description = read_urdf(document) if read is None else read(document)
    if unread := [*left_out_sentences(description), *(() if read else sentences(document.root, document.source))]:
        more = f" ({len(unread)} such sentences: ulna inspect)" if len(unread) > 1 else ""
        warnings.warn(unread[0] + more, DescriptionWarning, stacklevel=3)
    if srdf is None and bundled is not None:
        srdf = bundled.semantics()
    if srdf is None and document.folder is not None:  # texts and bundled robots have no neighboring files
        description = replace(description, srdf=srdf_beside(document, document.folder, description, xacro_args))
    elif srdf is not None and srdf is not False:
        description = replace(description, srdf=_given_srdf(srdf, document, description, xacro_args))
    return description, None if bundled is None else bundled.home


def _other_format(document: Document) -> Callable[[Document], Description] | None:
    """The reader of a document that is not URDF, by its root element; None for URDF."""
    return {"mujoco": read_mjcf, "sdf": read_sdf}.get(etree.QName(document.root).localname)


def left_out_sentences(description: Description) -> list[str]:
    """A sentence with file and line for each omitted part of a document."""
    warned = [part for part in description.left_out if part.is_warned]
    places = [description.source if part.line is None else f"{description.source}:{part.line}" for part in warned]
    return [f"{place}: {part.where}: {part.message}" for place, part in zip(places, warned, strict=True)]


def _given_srdf(srdf: object, document: Document, description: Description, xacro_args: Mapping[str, object]) -> Srdf:
    """The SRDF at a path or in a text; names that the robot lacks cause one warning.

    A xacro file gets the URDF's values for the arguments that it defines.
    """
    path_or_text = _checked_source("srdf", srdf, "a path or SRDF text")
    opened = open_document("srdf", path_or_text, "SRDF", document.package_dirs)
    semantics = matched(read_srdf(expanded(opened, shared_arguments(opened, xacro_args))), description)
    for first in semantics.warnings[:1]:
        count = len(semantics.warnings)
        more = f" ({count} such sentences: robot.srdf.warnings)" if count > 1 else ""
        warnings.warn(first + more, DescriptionWarning, stacklevel=4)
    return semantics


def urdf_text(
    source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path], mesh_paths: str = "given"
) -> str:
    """The URDF text of a source, even if it cannot be loaded; a xacro file is expanded."""
    document, _ = _document(source, xacro_args, package_dirs)
    read = _other_format(document)
    text = decoded(document) if read is None else write_urdf(read(document))
    return with_mesh_paths(mesh_paths, text, document.folder, document.package_dirs)


def _document(
    source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]
) -> tuple[Document, Bundled | ArmTable | None]:
    """The expanded document of a source, and its bundled robot, if it is one."""
    source = _checked_source("source", source, "a name, a path or URDF text")
    if not isinstance(xacro_args, Mapping):
        raise InputError("xacro_args", f"{xacro_args!r}; a dict of names and values is expected")
    for name, value in xacro_args.items():
        if value is None:
            raise InputError("xacro_args", f"{name}: None; a value is expected, and without one the argument is left out")
    folders = as_package_dirs(package_dirs)
    bundled = BUNDLED.get(source) if isinstance(source, str) else None
    if bundled is not None:
        warn_of_arguments(str(source), xacro_args)
        return Document(bundled.text(), bundled.file, package_dirs=folders), bundled
    if isinstance(source, str) and not is_text(source) and _may_be_a_name(source):
        named = find_by_name(source)
        source, xacro_args, folders = named.path, {**named.xacro_args, **xacro_args}, (*folders, *named.package_dirs)
    return expanded(open_document("source", source, "URDF", folders), xacro_args), None


def _may_be_a_name(source: str) -> bool:
    """Whether a text does not look like a path, and no file of that name exists."""
    path = Path(source)
    try:
        return path.name == source and path.suffix not in _SUFFIXES and len(source) < _LONGEST_NAME and not path.exists()
    except (OSError, ValueError):  # too long for a path, or with a character that no path has
        return False


def _checked_source(argument: str, source: object, expected: str) -> str | Path:
    if not isinstance(source, (str, Path)):
        raise InputError(argument, f"{type(source).__name__}; {expected} is expected")
    if isinstance(source, str) and not source.strip():
        raise InputError(argument, f"an empty string; {expected} is expected")
    return source
