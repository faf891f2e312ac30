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
        T: T_base_ellipsoid, shape (4, 4): its origin is the link's, its x axis the longest half axis.
        radii: The half axes, shape (3,): the maximum speeds of the link along these axes [m/s] for joint velocities of norm 1.
        singular_values: The singular values of the whole Jacobian, in meters and radians, largest first.
        manipulability: ``robot.manipulability``.
    """

    T: Array
    radii: Array
    singular_values: Array
    manipulability: float


def mobility(robot: Robot, q: ArrayLike, link: str) -> Mobility:
    """Compute the ellipsoid {J u : |u| = 1} of linear velocities.

    J are the linear rows of the Jacobian. The ellipsoid's axes are the left singular vectors of J, its radii the singular values.
    Planar and floating joints are left out, since they do not move while a hand is dragged. Source: T. Yoshikawa, Manipulability
    of robotic mechanisms (Int. J. Robotics Research, 1985).
    """
    J = robot.jacobian(q, link=link)[:, driven_columns(robot, link)]
    axes, radii, _ = np.linalg.svd(np.hstack([J[:3], np.zeros((3, 3))]))
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    T = robot.forward_kinematics(q, link=link).copy()
    T[:3, :3] = axes
    values = np.asarray(np.linalg.svd(J, compute_uv=False), dtype=np.float64)
    return Mobility(T, radii, values, float(robot.manipulability(q, link=link)))


def driven_columns(robot: Robot, link: str) -> list[int]:
    """The entries of q that move a link, without planar and floating joints."""
    types = {joint.name: joint.type for joint in robot.description.joints}
    own = [
        column
        for name, place in zip(robot.joint_names, robot.joint_slices, strict=True)
        if types[name] not in BASES
        for column in range(place.start, place.stop)
    ]
    return [column for column in robot.tree.moving_columns(link).tolist() if column in own]
