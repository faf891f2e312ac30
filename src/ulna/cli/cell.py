"""Reads the options of a command that define obstacles and collision shapes.

``--scene``, ``--box`` and ``--cloud`` define obstacles. ``--meshes`` selects the shapes that are checked in place of the robot's
collision meshes.
"""

import warnings
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from ulna.cli.depends import Depends, Json
from ulna.cli.options import AnyRobot, Degrees
from ulna.cli.output import warn
from ulna.cli.targets import BOX, numbers
from ulna.collision.clouds import PointCloud
from ulna.collision.scene_file import load_world
from ulna.collision.world import World
from ulna.description.meshes.hulls import in_place_of_meshes, n_collision_meshes
from ulna.description.names.panda import INSTALL_MESHES
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.errors import FileError, GeometryError, MissingExtraError, UnitWarning, install_command
from ulna.robot import Robot
from ulna.robot.load import with_meshes


def _advice() -> str:
    hulls, pieces = install_command("hulls"), install_command("decompose")
    return f"--meshes hulls ({hulls}) or --meshes decompose ({pieces}) checks convex shapes in their place"


class InPlace(StrEnum):
    """Shapes that are checked in place of collision meshes."""

    HULLS = "hulls"
    DECOMPOSE = "decompose"
    NONE = "none"


Scene = Annotated[Path | None, typer.Option(metavar="FILE", help="A scene file: the obstacles, as `ulna view` saves them.")]
Boxes = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NUMBERS", help='A box: "x, y, z, roll, pitch, yaw, length, width, height"; repeatable: box 1, box 2 ...'
    ),
]
Clouds = Annotated[
    list[Path] | None,
    typer.Option(metavar="FILE", help="Points as an obstacle: a .npy, .xyz, .csv, .txt, .ply or .pcd file, in m; repeatable."),
]
CloudRadius = Annotated[float, typer.Option(metavar="M", help="The radius of the ball around each point of --cloud [m].")]
Meshes = Annotated[
    InPlace | None,
    typer.Option(
        "--meshes",
        help="The shapes to check in place of collision meshes: convex hulls, which fill hollows; a decomposition into convex "
        "pieces, which takes minutes once; or none. By default hulls, if the extra hulls is installed.",
    ),
]


def obstacles(
    *, scene: Scene = None, box: Boxes = None, cloud: Clouds = None, cloud_radius: CloudRadius = 0.01, degrees: Degrees = False
) -> World | None:
    """The world of a scene file, boxes and clouds; None if no option is given."""
    if scene is None and not box and not cloud:
        return None
    world = World() if scene is None else load_world(scene)
    for k, text in enumerate(box or (), start=1):
        *place, length, width, height = numbers("--box", text, BOX, degrees=degrees)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnitWarning)  # the option has warned about the unit already
            world.add(f"box {k}", Box((length, width, height)), pose(place[:3], place[3:]))
    for path in cloud or ():
        world.add(path.stem, PointCloud.from_file(path, radius=cloud_radius))
    return world


Obstacles = Annotated[World | None, Depends(obstacles)]


def checked_robot(robot: AnyRobot, *, meshes: Meshes = None, as_json: Json = False) -> Robot:
    """The robot with convex shapes in place of its collision meshes, ready for collision checks.

    A line on standard error names the shapes, unless JSON is printed.
    """
    count = n_collision_meshes(robot.description)
    if count and meshes is InPlace.NONE:
        raise GeometryError(f"{count} of its collision shapes are meshes, which cannot be checked directly; {_advice()}")
    return with_chosen_shapes(robot, meshes, quiet=as_json)


CheckedRobot = Annotated[Robot, Depends(checked_robot)]


def shown_robot(robot: AnyRobot, *, meshes: Meshes = None) -> Robot:
    """The robot of ``checked_robot``; without ``--meshes``, a robot whose meshes cannot be converted is shown unchecked."""
    try:
        return with_chosen_shapes(robot, meshes)
    except (FileError, MissingExtraError) as error:
        if meshes is not None:
            raise
        typer.echo(f"collisions are not checked: {error}", err=True)
        return robot


ShownRobot = Annotated[Robot, Depends(shown_robot)]


def with_chosen_shapes(robot: Robot, meshes: InPlace | None, *, quiet: bool = False) -> Robot:
    """The robot with its collision meshes converted; unless ``quiet``, standard error names the shapes and the SRDF in use."""
    if robot.srdf.found_at and not quiet:
        typer.echo(f"{robot.srdf.source} next to the URDF allows contacts between links; --no-srdf ignores it", err=True)
    if not n_collision_meshes(robot.description) or meshes is InPlace.NONE:
        return robot
    if meshes is InPlace.DECOMPOSE:
        typer.echo("decomposing meshes; each takes seconds to minutes, and is cached for the next run", err=True)
    shaped = with_meshes(robot, meshes or InPlace.HULLS)
    if not quiet:
        typer.echo(in_place_of_meshes(shaped.description), err=True)
    return shaped


def warn_of_missing(meshes: Sequence[str]) -> None:
    """Print one sentence on standard error about meshes that are not shown; each entry is an address and the reason."""
    if not meshes:
        return
    if meshes[0].startswith("package://example-robot-data/"):
        advice = f"{INSTALL_MESHES} installs them"
    else:
        advice = f"{meshes[0].partition('; tried')[0]}; `ulna inspect` lists where they were looked for"
    warn(f"collision shapes are drawn in place of {len(meshes)} missing meshes: {advice}")
