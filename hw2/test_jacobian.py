"""Prints True if the Jacobian agrees with central differences of the end-effector's pose."""

import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends the script without a traceback, even during the imports

import numpy as np
from panda import HOME, make_robot

STEP = 1e-6  # rad


def by_differences(robot, joints):
    """The Jacobian by central differences of the pose, shape (6, 7)."""
    R = robot.forward_kinematics_urdf(joints)[-1][:3, :3]
    columns = []
    for turn in STEP * np.eye(7):
        ahead, behind = (robot.forward_kinematics_urdf(joints + side * turn)[-1] for side in (1, -1))
        W = (ahead[:3, :3] - behind[:3, :3]) @ R.T / (2 * STEP)  # the angular velocity as a skew matrix
        columns.append([*(ahead[:3, 3] - behind[:3, 3]) / (2 * STEP), W[2, 1], W[0, 2], W[1, 0]])
    return np.transpose(columns)


if __name__ == "__main__":
    robot = make_robot()
    print(np.allclose(robot.jacobian(HOME), by_differences(robot, np.array(HOME)), rtol=0, atol=1e-8))
