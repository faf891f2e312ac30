"""Reads a description as far as it can be read: the robot if it loads, its XML, its links in a tree."""

import warnings
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from ulna.description.document import Document, expanded, is_text
from ulna.description.file_bytes import file_bytes
from ulna.description.packages import as_package_dirs
from ulna.description.xml import LONGEST, parse
from ulna.errors import DescriptionError, DescriptionWarning, InputError
from ulna.inspection.result import TreeRow
from ulna.robot import Robot, load

_ARGUMENTS = ("source", "package_dirs", "xacro_args")  # of ``load``: other input errors are about the document's own numbers


@dataclass(frozen=True)
class Inspected:
    """A description: ``robot``, or the ``error`` of loading it; ``root`` is None if it is not XML; ``warnings`` of loading it.

    Its meshes are searched in ``folder`` and ``package_dirs``; of a robot given by name, in those of its package.
    """

    source: str
    folder: Path | None
    package_dirs: tuple[Path, ...]
    root: etree._Element | None
    robot: Robot | None
    error: DescriptionError | InputError | None
    warnings: tuple[str, ...] = ()


def read_inspected(source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]) -> Inspected:
    """The document of a name, a path or a text; an error of ``ulna.load`` is stored, not raised.

    Raises:
        FileError: There is no such file, or it cannot be read.
    """
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", DescriptionWarning)
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
    said = tuple(str(one.message) for one in caught)
    return Inspected(description.source, description.folder, description.package_dirs, root, robot, None, said)


def _path(source: str | Path) -> Path | None:
    """The path that a source is, or None for the text itself or a name."""
    return None if (isinstance(source, str) and is_text(source)) or not Path(source).is_file() else Path(source)


def _elements(
    text: bytes, source: str, folder: Path | None, xacro_args: Mapping[str, object], package_dirs: tuple[Path, ...]
) -> etree._Element | None:
    """The root of a document that was refused: the expanded one of a xacro file, or None if it is not XML or does not expand."""
    try:
        root = expanded(Document(text, source, folder, package_dirs), xacro_args).root
    except (DescriptionError, InputError):
        return None
    return root if root.tag == "robot" else None


def tree_rows(root: etree._Element) -> tuple[TreeRow, ...]:
    """A row for each link: from the links without a parent down, each link once, and then what only loops reach."""
    links = [link.get("name", "") for link in root.iterfind("link")]
    carried: defaultdict[str, list[TreeRow]] = defaultdict(list)
    for joint in root.iterfind("joint"):
        parent, child = (_link(joint, key) for key in ("parent", "child"))
        carried[parent].append(TreeRow(0, child, joint.get("name", ""), joint.get("type", "")))
    children = {row.link for rows in carried.values() for row in rows}
    rows: list[TreeRow] = []
    seen: set[str] = set()
    for start in [*(link for link in links if link not in children), *links]:
        waiting = [TreeRow(0, start)] if start not in seen else []
        while waiting:
            row = waiting.pop()
            rows.append(row)
            if row.link not in seen:
                seen.add(row.link)
                waiting += [TreeRow(row.depth + 1, one.link, one.joint, one.type) for one in reversed(carried[row.link])]
    return tuple(rows)


def _link(joint: etree._Element, key: str) -> str:
    element = joint.find(key)
    return "" if element is None else element.get("link", "")
