"""The robot that a user holds, and how it is loaded."""

from ulna.robot.load import load
from ulna.robot.robot import Robot

__all__ = ["Robot", "load"]
