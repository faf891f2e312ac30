"""``ulna view``: a robot on a page of this machine."""

import logging
import os
import warnings
from contextlib import suppress
from typing import Annotated

import typer

from ulna.cli.meshes import Hulls, Meshes, with_shapes_if_any
from ulna.cli.options import (
    SERVED,
    Base,
    Degrees,
    NoOpen,
    PackageDirs,
    Positions,
    RobotName,
    Scene,
    SrdfFile,
    Tip,
    XacroArgs,
    as_options,
    load_robot,
    positions,
    world_of,
)
from ulna.cli.output import printable, warn
from ulna.viewer.open_page import view as open_view

Host = Annotated[str, typer.Option(help="The address to listen on; any but 127.0.0.1, localhost and ::1 lets other machines in.")]
Port = Annotated[int, typer.Option(min=0, max=65535, help="Its port; 0 takes a free one.")]
_PATIENCE_S = 2.0


def view(
    robot: RobotName = "panda",
    *,
    scene: Scene = None,
    q: Positions = None,
    degrees: Degrees = False,
    meshes: Meshes = None,
    hulls: Hulls = False,
    host: Host = "127.0.0.1",
    port: Port = 8080,
    no_open: NoOpen = False,
    base: Base = None,
    tip: Tip = None,
    srdf: SrdfFile = None,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
) -> None:
    """Any robot in the browser: drag its hand, move its joints, put obstacles in its way; see distances and what it touches.

    Ctrl-C ends it.
    """
    arm = load_robot(robot, xacro_arg, package_dir, base=base, tip=tip, srdf=srdf)
    arm = with_shapes_if_any(arm, meshes, hulls=hulls)
    start = positions("--q", q, arm, degrees=degrees)
    with as_options(SERVED):
        shown = open_view(arm, world_of(scene), q=start, host=host, port=port, open_browser=not no_open)
    with suppress(KeyboardInterrupt):
        typer.echo(f"{printable(arm.name)} is at {shown.url}  (Ctrl-C ends it)")
        for mesh in shown.arm.missing:
            warn(f"not shown: {mesh}")
        shown.wait()
    warnings.simplefilter("ignore")  # open pages cause warnings when the server is stopped
    logging.disable()
    if not shown.stop(within=_PATIENCE_S):
        os._exit(0)  # a compilation is running, which takes long; a normal exit during it would abort
