"""``ulna ros1 demo`` and ``ulna ros2 demo``: the demo in RViz. Used by ``demo.command``."""

from importlib import import_module
from typing import Annotated

import typer

from ulna.demo.ros.adapter import load_ros
from ulna.demo.scenario import Demo

ros1 = typer.Typer(no_args_is_help=True, help="The demo in ROS 1: docs/ros.md says what it needs.")
ros2 = typer.Typer(no_args_is_help=True, help="The demo in ROS 2: docs/ros.md says what it needs.")


@ros1.command("demo")
def ros1_demo(*, rviz: Annotated[bool, typer.Option(help="Open RViz, if there is one and a screen for it.")] = True) -> None:
    """The arm, the box and the light in RViz, all in one command.

    It starts a master if there is none, robot_state_publisher and RViz, and ends what it started.
    """
    load_ros(1)
    import_module("ulna.demo.ros.ros1_demo").run(rviz=rviz)


@ros2.command("demo")
def ros2_demo() -> None:
    """One node that publishes the arm, the boxes and the light, and offers the box's handles: for your own RViz 2."""
    load_ros(2).play(Demo())


@ros1.callback()
@ros2.callback()
def _group() -> None:
    pass
