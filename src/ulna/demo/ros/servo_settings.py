"""Holds the settings of a servo node; needs no ROS."""

from enum import StrEnum
from typing import NamedTuple


class Output(StrEnum):
    """The message type for a controller."""

    TRAJECTORY = "trajectory"
    POSITIONS = "positions"


class Settings(NamedTuple):
    """The settings of a node.

    Attributes:
        link: The link to which poses and twists refer.
        rate: Ticks per second [Hz].
        acceleration: Limit of each joint [rad/s^2 or m/s^2].
        jerk: Limit of each joint [rad/s^3 or m/s^3]; None for no limit.
        clearance: Minimum distance from objects [m].
        tracking_error: Tolerance of each joint's distance from its command [rad or m]; 0: measurements are read at the start
            alone.
        output: The type of the output messages.
        topic: Their topic; None for the default of the controller.
    """

    link: str
    rate: float
    acceleration: float
    jerk: float | None
    clearance: float
    tracking_error: float
    output: Output
    topic: str | None
