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
    """Load a robot from a name, a file or a text.

    Args:
        source: A bundled name (``"panda"``, ``"ur10e"``), the path of a ``.urdf``, ``.xacro`` or ``.urdf.xacro`` file, or URDF
            text. Or a model in SDF (Gazebo) or MJCF (MuJoCo, with the extra ``mujoco``). Or a robot of the installed packages
            example-robot-data (``"ur5"``, ``"talos"``) or robot_descriptions (``"draco3"``); nothing is downloaded. Bundled names
            are tried first, then files, then the packages in this order.
        xacro_args: Arguments of a xacro file, or of the one macro that it defines; also the values of ``$(env NAME)`` in it.
        package_dirs: Folders that contain the packages of ``package://`` and ``$(find ...)``, or such packages themselves. A
            xacro file may only read files in them, in its own folder and in its package.
        base: The first link of the robot; the root unless given.
        tip: The last link of the robot: only the chain from base to tip is loaded.
        srdf: The path or the text of a semantic description: groups, named configurations, allowed collisions. References to
            parts that the robot lacks are ignored, with a ``DescriptionWarning``. Unless given, it is searched beside the URDF:
            in its folder, in ``../srdf`` of its package, and in ``config`` of a package ``NAME_moveit_config`` that depends on
            its package. Its robot's name and links must match the URDF. ``robot.srdf.found_at`` is its path,
            ``robot.srdf.passed_over`` lists the files not used. False loads none.
        meshes: The replacement for collision meshes. None keeps the meshes, and collision queries raise an error. ``"hulls"``:
            convex hulls (``Robot.with_convex_hulls``); ``"decompose"``: convex pieces (``Robot.with_convex_pieces``).

    Faulty parts that affect no pose are left out, with a ``DescriptionWarning``, and so are arguments that a xacro file does not
    define. A robot with a reach of hundreds of meters gives a ``UnitWarning``; so do joint limits that are probably degrees.

    Raises:
        DescriptionError: The description is invalid; the message gives file and line.
        FileError: There is no such file or name, or it cannot be read.
        InputError: An argument has the wrong type, or ``meshes`` is none of these words.
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
        robot = Robot(part.description, home=[robot.home[column] for column in _matching_columns(part, robot)])
    return with_meshes(robot, meshes)


def with_meshes(robot: Robot, meshes: str | None) -> Robot:
    """A copy of the robot with its collision meshes replaced by a method of ``MESHES``; unchanged for None."""
    match meshes:
        case "hulls":
            robot = robot.with_convex_hulls()
        case "decompose":
            robot = robot.with_convex_pieces()
        case _:
            return robot
    check_shapes("meshes", robot.description)
    return robot


def _matching_columns(part: Robot, whole: Robot) -> list[int]:
    """The index in the whole robot's q of each entry of the part's q."""
    slices = dict(zip(whole.joint_names, whole.joint_slices, strict=True))
    return [column for name in part.joint_names for column in range(*slices[name].indices(whole.n_dof))]
