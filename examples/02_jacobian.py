"""Builds the Jacobian column by column: column i is the velocity of the hand when joint i alone turns."""

import sys

import numpy as np

import ulna

robot = ulna.load("panda")
J = robot.jacobian(robot.home)
T_base_hand = robot.forward_kinematics(robot.home)

for i, name in enumerate(robot.joint_names):
    T_base_joint = robot.forward_kinematics(robot.home, link=f"panda_link{i + 1}")
    axis = T_base_joint[:3, 2]  # joints turn about the z axis of their frames
    arm = T_base_hand[:3, 3] - T_base_joint[:3, 3]  # from the joint to the hand
    column = np.concatenate([np.cross(axis, arm), axis])
    print(f"{name}: v = {column[:3].round(3)} m/s, w = {column[3:].round(3)} rad/s for 1 rad/s")
    assert np.allclose(J[:, i], column, atol=1e-12)

# A small turn of all joints moves the hand by J dq, to first order.
dq = np.full(robot.n_dof, 1e-4)
moved = robot.forward_kinematics(robot.home + dq)[:3, 3] - T_base_hand[:3, 3]
print(f"predicted {(J @ dq)[:3]} m, moved {moved} m")
assert np.abs(moved - (J @ dq)[:3]).max() < 1e-7

if "--view" in sys.argv:
    with ulna.view(robot, open_browser=True) as view:
        print(f"{view.url}: drag the hand; Manipulability in the tab Move draws the ellipsoid; Ctrl-C ends", flush=True)
        view.wait()
