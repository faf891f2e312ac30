"""Reads a description as far as possible, runs every check on it, and lists its tree."""

from __future__ import annotations

import warnings
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from ulna.description.document import Document, expanded, is_text
from ulna.description.file_bytes import file_bytes
from ulna.description.load import left_out_sentences
from ulna.description.packages import as_package_dirs
from ulna.description.unread import sentences
from ulna.description.urdf_writer import expressible_in_urdf, write_urdf
from ulna.description.xml import LONGEST, parse
from ulna.errors import DescriptionError, DescriptionWarning, InputError, UnitWarning
from ulna.ik.closed_form.closed_form import closed_form_of
from ulna.inspection.boxes import Boxes
from ulna.inspection.elements import element_findings
from ulna.inspection.joints import joint_findings, name_findings
from ulna.inspection.links import mesh_findings, shape_findings
from ulna.inspection.loaded import robot_findings, stretched_length
from ulna.inspection.masses import inertia_findings, mass_findings
from ulna.inspection.result import ERROR, NOTE, WARNING, Finding, Inspection, Severity, TreeRow
from ulna.robot import Robot, load
from ulna.robot.hand_link import hand_link

_ARGUMENTS = ("source", "package_dirs", "xacro_args")  # of ``load``; other input errors are about the document's own numbers


def inspect(
    source: str | Path, *, xacro_args: Mapping[str, object] | None = None, package_dirs: Iterable[str | Path] = ()
) -> Inspection:
    """Check a robot description, even one that ``ulna.load`` refuses; that error is then the first finding.

    Args:
        source: A bundled name, the path of a ``.urdf``, ``.xacro`` or ``.urdf.xacro`` file, or URDF text; or SDF or MJCF.
        xacro_args: Arguments of a xacro file, or of the one macro that it defines.
        package_dirs: Folders that contain the packages of ``package://`` and ``$(find ...)``.

    Returns:
        An ``Inspection``: its ``findings`` are errors, then warnings, then notes. ``print`` it.

    Raises:
        FileError: There is no such file, or it cannot be read.

    Example:
        >>> print(inspect('<robot name="r"><link name="a"/><link name="A"/></robot>'))
        URDF text: cannot be loaded
        error document: 2 links have no parent (a, A): one root is expected
        warning link 'A': differs from 'a' by case only
        note document: no link has a visual shape
        note document: no link has a collision shape
    """
    package_dirs = tuple(package_dirs) if isinstance(package_dirs, Iterator) else package_dirs  # it is iterated twice
    document = read_inspected(source, xacro_args or {}, package_dirs)
    robot, root = document.robot, document.root
    reach = None if robot is None else stretched_length(robot)
    form = None if robot is None else closed_form_of(robot.tree, robot.tip or hand_link(robot))
    found = list(_findings(document, reach))
    ordered = [finding for severity in Severity for finding in found if finding.severity == severity]
    return Inspection(
        source=document.source,
        name="" if root is None else root.get("name", ""),
        loads=robot is not None,
        findings=tuple(ordered),
        tree=() if root is None else tree_rows(root),
        n_links=0 if root is None else len(root.findall("link")),
        joint_types={} if root is None else dict(Counter(joint.get("type", "") for joint in root.iterfind("joint"))),
        n_dof=None if robot is None else robot.n_dof,
        reach=reach,
        closed_form="" if form is None else str(form),
    )


def _findings(document: Inspected, reach: float | None) -> Iterator[Finding]:
    error, root = document.error, document.root
    line = error.line if isinstance(error, DescriptionError) else None
    if error is not None:
        message = error.message if isinstance(error, DescriptionError) else str(error)
        yield Finding(ERROR, "document", message, line)
    if root is None:
        return
    left_out = () if document.robot is None else document.robot.description.left_out
    inertias, boxes = inertia_findings(root, loads=document.robot is not None), Boxes(document)
    own = [*element_findings(root), *name_findings(root), *joint_findings(root), *shape_findings(root), *inertias]
    lines = {part.line for part in left_out}  # a fault that was left out has its own finding, and is no error
    own = [one for one in own if one.severity != ERROR or one.line not in lines]
    yield from own if error is None else _without_repeated(own, line)
    yield from (Finding(NOTE if part.is_note else WARNING, part.where, part.message, part.line) for part in left_out)
    yield from mesh_findings(root, document, boxes)
    yield from (Finding(WARNING, "document", sentence) for sentence in document.warnings)
    if document.robot is not None and reach is not None:
        yield from mass_findings(document.robot.description, boxes, reach)
        yield from robot_findings(document.robot, reach)


def _without_repeated(findings: list[Finding], line: int | None) -> list[Finding]:
    """The findings without the first error on the line of ``ulna.load``'s error, which reports the same fault."""
    repeated = next((k for k, one in enumerate(findings) if one.severity == ERROR and one.line == line is not None), None)
    return [one for k, one in enumerate(findings) if k != repeated]


@dataclass(frozen=True)
class Inspected:
    """A description: ``robot``, or the ``error`` of loading it; ``root`` is None if it is not XML.

    ``warnings`` are those of loading. Meshes are searched in ``folder`` and ``package_dirs``; for a robot given by name, in the
    folders of its package.
    """

    source: str
    folder: Path | None
    package_dirs: tuple[Path, ...]
    root: etree._Element | None
    robot: Robot | None
    error: DescriptionError | InputError | None
    warnings: tuple[str, ...] = ()


def read_inspected(source: str | Path, xacro_args: Mapping[str, object], package_dirs: Iterable[str | Path]) -> Inspected:
    """Read the document of a name, a path or a text; an error of ``ulna.load`` is stored, not raised."""
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", DescriptionWarning)
            warnings.simplefilter("ignore", UnitWarning)  # findings report the same
            robot = load(source, xacro_args=xacro_args, package_dirs=package_dirs)
    except (DescriptionError, InputError) as error:
        if isinstance(error, InputError) and error.argument in _ARGUMENTS:
            raise
        path = None if (isinstance(source, str) and is_text(source)) or not Path(source).is_file() else Path(source)
        name = getattr(error, "source", "") or ("URDF text" if path is None else path.name)
        folder, text = (None, str(source).encode()) if path is None else (path.parent, file_bytes(path, LONGEST))
        does_not_expand = str(getattr(error, "message", "")).startswith("xacro:")
        folders = as_package_dirs(package_dirs)
        root = None if does_not_expand else _elements(text, name, folder, xacro_args, folders)
        return Inspected(name, folder, folders, root, None, error)
    description = robot.description
    text = description.text or write_urdf(expressible_in_urdf(description))  # of MJCF and SDF: links and joints as URDF
    root = parse(text.encode(), description.source)
    for element in () if description.text else root.iter():
        element.sourceline = 0  # its lines are not lines of the document
    # ``load`` names the first part that is unread or left out; each part has its own finding.
    unread = [*left_out_sentences(description), *sentences(root, description.source)][:1]
    said = tuple(str(one.message) for one in caught if not str(one.message).startswith(tuple(unread)))
    return Inspected(description.source, description.folder, description.package_dirs, root, robot, None, said)


def _elements(
    text: bytes, source: str, folder: Path | None, xacro_args: Mapping[str, object], package_dirs: tuple[Path, ...]
) -> etree._Element | None:
    """The root of a refused document, xacro expanded; None if it is not XML or does not expand."""
    try:
        root = expanded(Document(text, source, folder, package_dirs), xacro_args).root
    except (DescriptionError, InputError):
        return None
    return root if root.tag == "robot" else None


def tree_rows(root: etree._Element) -> tuple[TreeRow, ...]:
    """A row for each link: depth first from the links without a parent, then links within loops."""
    links = [link.get("name", "") for link in root.iterfind("link")]
    carried: defaultdict[str, list[TreeRow]] = defaultdict(list)
    for joint in root.iterfind("joint"):
        parent, child = (next((end.get("link", "") for end in joint.iterfind(key)), "") for key in ("parent", "child"))
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
