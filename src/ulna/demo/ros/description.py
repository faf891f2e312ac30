"""Makes the URDF that RViz and robot_state_publisher read. Used by ``ros1_demo`` and ``ros2``."""

from collections.abc import Callable

from ulna.errors import FileError
from ulna.robot import Robot


def robot_description(robot: Robot, warn: Callable[[str], object]) -> str:
    """URDF whose meshes are ``file://`` addresses; if meshes are missing, with their given addresses, and a warning."""
    try:
        return robot.to_urdf(mesh_paths="file")
    except FileError as error:
        warn(f"the arm is seen by its boxes alone, for its meshes are not here (pip install example-robot-data): {error}")
        return robot.to_urdf()
