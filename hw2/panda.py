"""Makes the robot that the scripts of the assignment test."""

from pathlib import Path

from franka_robot import DH_PARAMS, HOME, FrankaRobot

URDF = Path(__file__).with_name("franka_robot.urdf")


def make_robot():
    """Make the robot of the assignment."""
    return FrankaRobot(URDF, DH_PARAMS, 7)


__all__ = ["HOME", "URDF", "make_robot"]
