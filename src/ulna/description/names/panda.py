"""Holds the Panda's DH table from the assignment, its home configuration, and the command that installs its meshes."""

from math import pi

# The package's code requires a simulator and a Python below 3.13, its meshes neither.
INSTALL_MESHES = "pip install --no-deps --ignore-requires-python dm-robotics-panda==0.4.8"

HOME = (0.0, -pi / 4, 0.0, -3 * pi / 4, 0.0, pi / 2, pi / 4)  # [rad]
# This description does not move the hand; it is drawn with its fingers half open.
FINGER_JOINTS, FINGER_POSITION = ("panda_finger_joint1", "panda_finger_joint2"), 0.02  # [m]
# Modified (Craig) rows: a [m], d [m], alpha [rad], theta_offset [rad]; joints 1 to 7, the flange, the end-effector. Source:
# Franka Control Interface documentation, "Denavit-Hartenberg parameters"; the last row is the assignment's.
DH_ROWS = (
    (0.0, 0.333, 0.0, 0.0),
    (0.0, 0.0, -pi / 2, 0.0),
    (0.0, 0.316, pi / 2, 0.0),
    (0.0825, 0.0, pi / 2, 0.0),
    (-0.0825, 0.384, -pi / 2, 0.0),
    (0.0, 0.0, pi / 2, 0.0),
    (0.088, 0.0, pi / 2, 0.0),
    (0.0, 0.107, 0.0, 0.0),
    (0.0, 0.1034, 0.0, 0.0),
)
DH_JOINT_TYPES = ("revolute",) * 7 + ("fixed",) * 2
# The links whose poses the DH table gives, row by row.
DH_LINKS = (*(f"panda_link{k}" for k in range(1, 9)), "panda_ee")
