"""``ulna ros1`` and ``ulna ros2``: the demo in RViz, and a servo as a node."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from ulna.cli.cell import Obstacles, ShownRobot
from ulna.cli.depends import as_options, command
from ulna.cli.options import Jerk, LinkName
from ulna.cli.output import printable, warn, write
from ulna.demo.ros.adapter import load_ros, node_compiler
from ulna.demo.ros.description import robot_description
from ulna.demo.ros.servo_settings import Output, Settings
from ulna.demo.scenario import RATE_HZ, Demo
from ulna.engine.progress import progress_bar
from ulna.errors import needs_extra
from ulna.robot import load
from ulna.robot.hand_link import hand_link

ros1 = typer.Typer(no_args_is_help=True, help="The demo in ROS 1; docs/ros.md lists its requirements.")
ros2 = typer.Typer(no_args_is_help=True, help="The demo and a servo in ROS 2; docs/ros.md lists their requirements.")


@ros1.command("demo")
def ros1_demo(*, rviz: Annotated[bool, typer.Option(help="Open RViz, if it is installed and there is a screen.")] = True) -> None:
    """Show the arm, the box and the light in RViz, all in one command.

    It starts a master if there is none, robot_state_publisher and RViz, and ends all that it started.
    """
    load_ros(1)
    with node_compiler() as compiler:
        import_module("ulna.demo.ros.ros1_demo").run(compiler.ask, rviz=rviz)


@ros1.command("record")
def ros1_record(
    path: Annotated[Path, typer.Argument(help="The video, an .mp4.", show_default=False)],
    *,
    seconds: Annotated[float, typer.Option(help="The duration.")] = 30.0,
) -> None:
    """Record RViz without a display while the mouse drags the box by its arrows and a ring.

    It needs Xvfb and xdotool too. It starts and ends all programs that it needs.
    """
    load_ros(1)
    with needs_extra("the video", "viewer", "av", "PIL"):
        video = import_module("ulna.demo.ros.rviz_video")
    with (
        node_compiler() as compiler,
        as_options({"path": "PATH", "seconds": "--seconds"}),
        progress_bar() as progress,
    ):
        task = progress.add_task(path.name, total=round(seconds * RATE_HZ))
        video.record_rviz(path, seconds, compiler, lambda done: progress.update(task, completed=done))
    typer.echo(printable(f"{path}: {seconds:g} s, {path.stat().st_size / 1e6:.2f} MB"))


@ros1.command("description")
def ros1_description() -> None:
    """Print the Panda's URDF for robot_description, with absolute mesh addresses and finger joints. Needs no ROS."""
    write(robot_description(load("panda"), warn))


@ros2.command("demo")
def ros2_demo() -> None:
    """Run one node for your own RViz 2: the arm, its boxes, the light, and the box's handles."""
    ros = load_ros(2)
    with node_compiler() as compiler:
        ros.play(Demo(), compiler.ask)


Topic = Annotated[str | None, typer.Option(help="The topic of the commands; by default that of such a controller.")]


@ros2.command("servo")
@command
def ros2_servo(
    robot: ShownRobot,
    world: Obstacles,
    *,
    link: LinkName = None,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Commands per second.")] = 100.0,
    acceleration: Annotated[float, typer.Option(help="Maximum acceleration of each joint [rad/s² or m/s²].")] = 5.0,
    jerk: Jerk = None,
    clearance: Annotated[float, typer.Option(metavar="M", help="Minimum distance from objects [m].")] = 0.01,
    tracking_error: Annotated[
        float, typer.Option(help="Maximum deviation of /joint_states from the command [rad or m]; 0: not checked.")
    ] = 0.0,
    output: Annotated[Output, typer.Option(help="The messages: JointTrajectory or Float64MultiArray.")] = Output.TRAJECTORY,
    topic: Topic = None,
) -> None:
    """Steer an arm by the topics of MoveIt Servo: reads twists and poses, sends commands without collisions. Ctrl-C ends it."""
    node = load_ros(2, "servo_node", "ulna servo")
    settings = Settings(link or hand_link(robot), rate, acceleration, jerk, clearance, tracking_error, output, topic)
    with node_compiler() as compiler:
        node.steer(robot, world, settings, compiler.ask)


@ros1.callback()
@ros2.callback()
def _group() -> None:
    pass
