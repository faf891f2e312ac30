"""Computes forward kinematics from a URDF and from a Denavit-Hartenberg table, and compares both."""

import numpy as np

import ulna
from ulna.description.names.panda import DH_JOINT_TYPES, DH_LINKS, DH_ROWS

robot = ulna.load("panda")
dh_robot = ulna.Robot.from_dh(DH_ROWS, convention="modified", joint_types=DH_JOINT_TYPES)

# The URDF places each joint by xyz and rpy, the table by a, d, alpha and theta: two descriptions of the same seven axes.
q = robot.random(1000, seed=0)
T_urdf = robot.link_poses(q)[:, [robot.link_names.index(name) for name in DH_LINKS]]
T_dh = dh_robot.link_poses(q)[:, 1:]  # all but the base

difference = np.abs(T_urdf - T_dh).max()
print(f"nine frames, 1000 configurations: the largest difference is {difference:.1e}")
assert difference < 1e-12
