"""The numbers of the assignment: the table, the home configuration, and the robot made of them."""

from pathlib import Path

from franka_robot import FrankaRobot

from ulna.description.names.panda import DH_ROWS, HOME

URDF = Path(__file__).with_name("franka_robot.urdf")


def make_robot():
    """The robot of the assignment."""
    return FrankaRobot(URDF, DH_ROWS, 7)


__all__ = ["HOME", "URDF", "make_robot"]
