"""Defines the assignment's demo without a screen: trajectory, movable box, light.

The numbers come from the assignment (section 5 and its demo).
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.pose import pose, rpy_from_matrix
from ulna.description.shapes import Box, Cylinder
from ulna.errors import UlnaError
from ulna.robot import Robot, load
from ulna.viewer.palette import GREEN, RED, UNKNOWN

RATE_HZ = 10.0
SEGMENT_S = 3.0
# Waypoints as changes from home: x, y, z [m], roll, pitch, yaw [rad]. The straight lines between them close a loop.
WAY_POINTS = (
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (0.1, 0.1, 0.0, 0.0, 0.0, 0.0),
    (0.0, 0.0, 0.1, 0.0, 0.0, pi / 2),
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
)
TOLERANCE = 1e-9  # [m, rad], of each sample's pose: the loop closes to 1e-6 rad
BOX_NAME = "box"
BOX = Box(extents=(0.15, 0.09, 0.126))
BOX_START = (0.5, 0.0, 0.21)
LIGHT = Cylinder(radius=0.05, length=0.1)
LIGHT_POSITION = (0.0, 0.3, 0.0)


class TrajectoryError(UlnaError, RuntimeError):
    """Inverse kinematics did not reach a sample of the trajectory."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A closed path: samples of q at RATE_HZ, shape (n + 1, n_dof); the last repeats the first approximately."""

    samples: NDArray[np.float64]

    @property
    def duration(self) -> float:
        """The time of one cycle [s]."""
        return (len(self.samples) - 1) / RATE_HZ

    def at(self, time: float) -> NDArray[np.float64]:
        """q, shape (n_dof,), at a time [s] of the repeated path, linear between samples."""
        place = time % self.duration * RATE_HZ
        k = min(int(place), len(self.samples) - 2)
        return self.samples[k] + (place - k) * (self.samples[k + 1] - self.samples[k])


def make_trajectory(robot: Robot) -> Trajectory:
    """Compute the trajectory: each sample by inverse kinematics from the sample before, with the home posture.

    The arm is redundant: without the posture the last sample would be 0.1 rad from home, and the arm would jump in every cycle.
    """
    T_home = robot.forward_kinematics(robot.home)
    home = np.concatenate([T_home[:3, 3], rpy_from_matrix(T_home)])
    n = round(SEGMENT_S * RATE_HZ)
    corners = home + np.array(WAY_POINTS)
    path = [a + (b - a) * k / n for a, b in pairwise(corners) for k in range(n)] + [corners[-1]]
    samples = [robot.home]
    for k, target in enumerate(path[1:], start=1):
        found = robot.inverse_kinematics(
            pose(target[:3], target[3:]),
            samples[-1],
            posture=robot.home,
            position_tolerance=TOLERANCE,
            rotation_tolerance=TOLERANCE,
        )
        if not found.success:
            raise TrajectoryError(f"sample {k} of the trajectory: {found}")
        samples.append(found.q)
    return Trajectory(np.array(samples))


class Demo:
    """The robot, its trajectory, and a world with the movable box."""

    def __init__(self, robot: Robot | None = None) -> None:
        self.robot = load("panda") if robot is None else robot
        self.world = World()
        self.world.add(BOX_NAME, BOX, pose(BOX_START))

    @cached_property
    def trajectory(self) -> Trajectory:
        """The path that the arm repeats; computed at the first access."""
        return make_trajectory(self.robot)

    def move_box(self, T_base_box: ArrayLike) -> None:
        """Put the movable box at a pose, shape (4, 4)."""
        self.world.move(BOX_NAME, T_base_box)

    def check(self, q: ArrayLike) -> Report:
        """The contacts of the movable box with the arm at q, shape (n_dof,); ``str(report)`` is the text beside the light."""
        return self.robot.check_collision(q, self.world, self_collision=False)


def light_color(report: Report | None) -> tuple[int, int, int]:
    """Red during contact, green without, gray while unknown. Red, green, blue in 0..255."""
    if report is None:
        return UNKNOWN
    return RED if report.in_collision else GREEN


def light_word(report: Report | None) -> str:
    """The text beside the light."""
    return "compiling ..." if report is None else str(report)
