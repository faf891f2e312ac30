"""Builds the drawing of the demo: solids with their names, poses and colors."""

from collections.abc import Iterator
from dataclasses import replace
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.demo.scenario import BOX, BOX_NAME, LIGHT, LIGHT_POSITION, light_color
from ulna.description.names import panda
from ulna.description.pose import pose
from ulna.description.shapes import Box, Cylinder
from ulna.robot import Robot
from ulna.viewer.palette import MOVABLE, Solid, collision_solids

WORD_POSITION = (0.0, 0.0, -LIGHT.length)  # [m], position of the text below the light, in the light's frame
_SHAFT, _HEAD = Cylinder(radius=0.004, length=0.2), Cylinder(radius=0.011, length=0.03)
_ALONG = {"x": (0.0, pi / 2, 0.0), "y": (-pi / 2, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}  # roll, pitch, yaw that turn z onto an axis
_AXES = ((255, 46, 100), (60, 190, 110), (50, 130, 220))
WORD_POSITION_IN_BASE = (LIGHT_POSITION[0], LIGHT_POSITION[1], LIGHT_POSITION[2] - LIGHT.length)


def standing_boxes(robot: Robot, q: ArrayLike) -> Iterator[Solid[Box]]:
    """The arm's collision boxes, pale, with their poses in the base at q, shape (n_dof,)."""
    places = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
    for solid in collision_solids(robot):
        yield replace(solid, link=robot.base, pose=places[solid.link] @ solid.pose)


def light(robot: Robot, report: Report | None) -> Solid[Cylinder]:
    """The light: red if anything touches, green if not, gray while unknown. ``light_word(report)`` is its text."""
    return Solid("light", robot.base, pose(LIGHT_POSITION), LIGHT, light_color(report), glows=True)


def movable_box(robot: Robot, T_base_box: NDArray[np.float64]) -> Solid[Box]:
    """The box that the user drags."""
    return Solid(BOX_NAME, robot.base, T_base_box, BOX, MOVABLE)


def box_handles(robot: Robot, T_base_box: NDArray[np.float64]) -> Iterator[Solid[Cylinder]]:
    """The arrows along the box's axes, colored as on the page and in RViz: x red, y green, z blue."""
    for (axis, rpy), color in zip(_ALONG.items(), _AXES, strict=True):
        for part, shape, middle in (("shaft", _SHAFT, _SHAFT.length / 2), ("head", _HEAD, _SHAFT.length)):
            T = T_base_box @ pose((0, 0, 0), rpy) @ pose((0, 0, middle))
            yield Solid(f"handle {axis}, {part}", robot.base, T, shape, color)


def joint_positions(robot: Robot, q: ArrayLike) -> dict[str, float]:
    """Joint positions by name [rad or m], with the fingers of the Panda, which its description fixes."""
    positions = dict(zip(robot.joint_names, map(float, np.asarray(q)), strict=True))
    return positions | (dict.fromkeys(panda.FINGER_JOINTS, panda.FINGER_POSITION) if robot.name == "panda" else {})
