"""Computes the manipulability ellipsoid of a link, and the singular values of its Jacobian."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.robot import Robot
from ulna.viewer.session.hand import BASES

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mobility:
    """The manipulability of a link at one q.

    Attributes:
        T: The ellipsoid's frame in the base, shape (4, 4): at the link's origin, its x axis the longest.
        radii: The half axes: the link's largest speeds along these axes [m/s] for joint rates of norm 1, shape (3,).
        singular_values: Those of the whole Jacobian, in meters and radians, largest first.
        manipulability: ``robot.manipulability``.
    """

    T: Array
    radii: Array
    singular_values: Array
    manipulability: float


def mobility(robot: Robot, q: ArrayLike, link: str) -> Mobility:
    """The ellipsoid {J u : |u| = 1} of the linear velocities: axes and radii are those of J J'.

    Planar and floating joints are left out: they do not move while a hand is dragged.
    Source: Yoshikawa, Manipulability of robotic mechanisms (Int. J. Robotics Research 1985).
    """
    J = robot.jacobian(q, link=link)[:, driven_columns(robot, link)]
    axes, radii, _ = np.linalg.svd(np.hstack([J[:3], np.zeros((3, 3))]))
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    T = robot.forward_kinematics(q, link=link).copy()
    T[:3, :3] = axes
    values = np.asarray(np.linalg.svd(J, compute_uv=False), dtype=np.float64)
    return Mobility(T, radii, values, float(robot.manipulability(q, link=link)))


def driven_columns(robot: Robot, link: str) -> list[int]:
    """The entries of q that move a link, without those of planar and floating joints."""
    types = {joint.name: joint.type for joint in robot.description.joints}
    own = [
        column
        for name, place in zip(robot.joint_names, robot.joint_slices, strict=True)
        if types[name] not in BASES
        for column in range(place.start, place.stop)
    ]
    return [column for column in robot.tree.moving_columns(link).tolist() if column in own]
