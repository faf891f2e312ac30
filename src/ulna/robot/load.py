"""Loads a robot from a file, a text or a name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from ulna.description.likely_units import check_description, check_shapes
from ulna.description.load import load_description
from ulna.description.subtree import cut_out
from ulna.errors import InputError, did_you_mean
from ulna.robot.robot import Robot

MESHES = ("hulls", "decompose")


def load(
    source: str | Path,
    *,
    xacro_args: Mapping[str, object] | None = None,
    package_dirs: Iterable[str | Path] = (),
    base: str | None = None,
    tip: str | None = None,
    srdf: str | Path | Literal[False] | None = None,
    meshes: str | None = None,
) -> Robot:
    """The robot of a description.

    Args:
        source: A bundled name (``"panda"``, ``"ur10e"``), the path of a ``.urdf``, ``.xacro`` or ``.urdf.xacro`` file, or URDF
            text; or SDF, a model of Gazebo, or MJCF, one of MuJoCo (with the extra ``mujoco``). Or the name of a robot of the
            packages example-robot-data (``"ur5"``, ``"talos"``) or robot_descriptions (``"draco3"``), where they are installed;
            nothing is downloaded. A bundled name comes first, then a file, then these in their order.
        xacro_args: Arguments of a xacro file, or of the one macro that it defines; and the values of ``$(env NAME)`` in it.
        package_dirs: Folders in which the packages of ``package://`` and ``$(find ...)`` lie, or such packages themselves. A
            xacro file reads files in them, in its own folder and in its package, and nowhere else.
        base: The link to begin at; the root unless given.
        tip: The link to end at: only the chain from base to tip is kept.
        srdf: The path or the text of a semantic description: groups, named configurations, pairs of links that may touch.
            References in it to parts that the robot lacks are ignored, with a ``DescriptionWarning``. Unless given, the one that
            lies beside the URDF is taken, if its robot's name and links are those of the URDF: in its folder, in ``../srdf`` of
            its package, or in ``config`` of a package ``NAME_moveit_config`` that depends on its package.
            ``robot.srdf.found_at`` is its path, ``robot.srdf.passed_over`` what is not used. False takes none.
        meshes: What to check in the place of collision meshes: None leaves them, and queries refuse them; ``"hulls"``: their
            convex hulls (``Robot.with_convex_hulls``); ``"decompose"``: convex pieces (``Robot.with_convex_pieces``).

    Faulty parts on which no pose depends are left out, with a ``DescriptionWarning``; so is an argument that a xacro file
    does not define. A robot that reaches hundreds of metres gives a ``UnitWarning``, and so do joint limits that are more likely
    degrees.

    Raises:
        DescriptionError: The description cannot be understood; the message gives file and line.
        FileError: There is no such file or name, or it cannot be read.
        InputError: An argument has the wrong type, or ``meshes`` is not one of these words.
        MissingExtraError: ``meshes`` needs an extra that is not installed.
        UnknownNameError: There is no such ``base`` or ``tip``.

    Example:
        >>> load("panda").n_dof
        7
    """
    if meshes not in (None, *MESHES):
        raise InputError("meshes", f"{meshes!r} is not known{did_you_mean(str(meshes), MESHES)}")
    description, home = load_description(source, xacro_args or {}, package_dirs, srdf)
    check_description("source", description)
    robot = Robot(description, home=home)
    if base is not None or tip is not None:
        part = Robot(cut_out(description, base, tip))
        robot = Robot(part.description, home=[robot.home[column] for column in _columns(part, robot)])
    return with_meshes(robot, meshes)


def with_meshes(robot: Robot, meshes: str | None) -> Robot:
    """The robot with its collision meshes replaced as a value of ``MESHES`` says; unchanged for None."""
    match meshes:
        case "hulls":
            robot = robot.with_convex_hulls()
        case "decompose":
            robot = robot.with_convex_pieces()
        case _:
            return robot
    check_shapes("meshes", robot.description)
    return robot


def _columns(part: Robot, whole: Robot) -> list[int]:
    """For each entry of the part's q, the entry of the whole's that means the same."""
    slices = dict(zip(whole.joint_names, whole.joint_slices, strict=True))
    return [column for name in part.joint_names for column in range(*slices[name].indices(whole.n_dof))]
