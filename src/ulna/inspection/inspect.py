"""Runs every check on a description and lists its tree."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from ulna.errors import DescriptionError
from ulna.inspection.elements import element_findings
from ulna.inspection.inspected import Inspected, read_inspected, tree_rows
from ulna.inspection.joints import joint_findings, name_findings
from ulna.inspection.links import inertia_findings, shape_findings
from ulna.inspection.meshes import mesh_findings
from ulna.inspection.result import Finding, Inspection, Severity
from ulna.inspection.robot_checks import closed_form_in_words, robot_findings, stretched_length


def inspect(
    source: str | Path, *, xacro_args: Mapping[str, object] | None = None, package_dirs: Iterable[str | Path] = ()
) -> Inspection:
    """The health of a robot description, also of one that ``ulna.load`` refuses: that error is then the first finding.

    Args:
        source: A bundled name, the path of a ``.urdf``, ``.xacro`` or ``.urdf.xacro`` file, or URDF text.
        xacro_args: Arguments of a xacro file, or of the one macro that it defines.
        package_dirs: Folders in which the packages of ``package://`` and ``$(find ...)`` lie.

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
    package_dirs = tuple(package_dirs) if isinstance(package_dirs, Iterator) else package_dirs  # it is gone through twice
    document = read_inspected(source, xacro_args or {}, package_dirs)
    robot, root = document.robot, document.root
    reach = None if robot is None else stretched_length(robot)
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
        closed_form="" if robot is None else closed_form_in_words(robot),
    )


def _findings(document: Inspected, reach: float | None) -> Iterator[Finding]:
    error, root = document.error, document.root
    line = error.line if isinstance(error, DescriptionError) else None
    if error is not None:
        message = error.message if isinstance(error, DescriptionError) else str(error)
        yield Finding(Severity.ERROR, "document", message, line)
    if root is None:
        return
    own = [*element_findings(root), *name_findings(root), *joint_findings(root), *shape_findings(root), *inertia_findings(root)]
    yield from own if error is None else _without_repeated(own, line)
    yield from mesh_findings(root, document)
    if document.robot is not None and reach is not None:
        yield from robot_findings(document.robot, reach)


def _without_repeated(findings: list[Finding], line: int | None) -> list[Finding]:
    """The findings without the first error on the line of the error of ``ulna.load``, which reports the same fault."""
    repeated = next(
        (k for k, one in enumerate(findings) if one.severity == Severity.ERROR and one.line == line is not None), None
    )
    return [one for k, one in enumerate(findings) if k != repeated]
