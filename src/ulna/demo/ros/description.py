"""The text that RViz and robot_state_publisher read the arm from."""

from collections.abc import Callable

from ulna.errors import FileError
from ulna.robot import Robot


def robot_description(robot: Robot, warn: Callable[[str], object]) -> str:
    """Expanded URDF whose meshes are ``file://`` addresses; without the meshes as it is, and ``warn`` is told."""
    try:
        return robot.to_urdf(mesh_paths="file")
    except FileError as error:
        warn(f"the arm is seen by its boxes alone, for its meshes are not here (pip install example-robot-data): {error}")
        return robot.to_urdf()
