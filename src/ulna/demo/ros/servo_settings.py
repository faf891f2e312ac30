"""Holds how a servo steers as a node; without ROS."""

from enum import StrEnum
from typing import NamedTuple


class Output(StrEnum):
    """What is published for a controller."""

    TRAJECTORY = "trajectory"
    POSITIONS = "positions"


class Settings(NamedTuple):
    """How a node steers.

    Attributes:
        link: The link that poses and twists are of.
        rate: Ticks a second [Hz].
        acceleration: Of each joint [rad/s^2 or m/s^2].
        jerk: Of each joint [rad/s^3 or m/s^3]; None for no limit.
        clearance: How near an object may be [m].
        tracking_error: How far each joint may be off its command [rad or m]; 0: what is measured is read at the start alone.
        output: What is published.
        topic: Where; None for the default of the controller.
    """

    link: str
    rate: float
    acceleration: float
    jerk: float | None
    clearance: float
    tracking_error: float
    output: Output
    topic: str | None
