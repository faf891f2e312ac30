"""Reads a description as far as it can be read: the robot if it loads, and the elements of its XML. Used by ``inspect``."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from ulna.description.document import Document, expanded, is_text
from ulna.description.file_bytes import file_bytes
from ulna.description.packages import as_package_dirs
from ulna.description.xml import LONGEST, parse
from ulna.errors import DescriptionError, InputError
from ulna.robot import Robot, load

_ARGUMENTS = ("source", "package_dirs", "xacro_args")  # of ``load``: other input errors are about the document's own numbers


@dataclass(frozen=True)
class Inspected:
    """A description: ``robot``, or the ``error`` of loading it; ``root`` is None if it is not XML.

    Its meshes are searched in ``folder`` and ``package_dirs``; of a robot given by name, in those of its package.
    """

    source: str
    folder: Path | None
    package_dirs: tuple[Path, ...]
    root: etree._Element | None
    robot: Robot | None
    error: DescriptionError | InputError | None


def read_inspected(source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]) -> Inspected:
    """The document of a name, a path or a text; an error of ``ulna.load`` is stored, not raised.

    Raises:
        FileError: There is no such file, or it cannot be read.
    """
    try:
        robot = load(source, xacro_args=xacro_args, package_dirs=package_dirs)
    except (DescriptionError, InputError) as error:
        if isinstance(error, InputError) and error.argument in _ARGUMENTS:
            raise
        path = _path(source)
        name = getattr(error, "source", "") or ("URDF text" if path is None else path.name)
        folder, text = (None, str(source).encode()) if path is None else (path.parent, file_bytes(path, LONGEST))
        does_not_expand = str(getattr(error, "message", "")).startswith("xacro:")
        folders = as_package_dirs(package_dirs)
        root = None if does_not_expand else _elements(text, name, folder, xacro_args, folders)
        return Inspected(name, folder, folders, root, None, error)
    description = robot.description
    root = parse(description.text.encode(), description.source)
    return Inspected(description.source, description.folder, description.package_dirs, root, robot, None)


def _path(source: str | Path) -> Path | None:
    """The path that a source is, or None for the text itself or a name."""
    return None if (isinstance(source, str) and is_text(source)) or not Path(source).is_file() else Path(source)


def _elements(
    text: bytes, source: str, folder: Path | None, xacro_args: Mapping[str, object], package_dirs: tuple[Path, ...]
) -> etree._Element | None:
    """The root of a document that was refused: the expanded one of a xacro file, or None if it is not XML or does not expand."""
    try:
        whole = expanded(Document(text, source, folder), xacro_args, package_dirs)
        root = parse(whole.text, source)
    except (DescriptionError, InputError):
        return None
    return root if root.tag == "robot" else None
