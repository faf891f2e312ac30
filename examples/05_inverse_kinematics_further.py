"""More inverse kinematics: a batch, a drill, every branch, a path without jumps, and a control loop."""

import numpy as np

import ulna

robot = ulna.load("panda")
rng = np.random.default_rng(0)

targets = robot.forward_kinematics(robot.random(1000, seed=rng))
found = robot.inverse_kinematics(targets)
print(f"a batch: {found}")
assert np.all(found.success)

drill = robot.inverse_kinematics(targets[0], task="pointing")
print(f"pointing: {drill}")
assert drill.success
assert np.abs(drill.residual[:5]).max() < 1e-5  # all components except the rotation about z

# A UR5e reaches most poses in eight configurations. Source of the table: Universal Robots, "Parameters for calculations of
# kinematics and dynamics".
rows = [
    (0, 0.1625, np.pi / 2, 0), (-0.425, 0, 0, 0), (-0.3922, 0, 0, 0),
    (0, 0.1333, np.pi / 2, 0), (0, 0.0997, -np.pi / 2, 0), (0, 0.0996, 0, 0),
]  # fmt: skip
ur5e = ulna.Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * 6, name="ur5e")
branches = ur5e.all_solutions(ur5e.forward_kinematics([0.3, -1.2, 1.5, -0.7, 1.1, 0.4]))
print(f"ur5e: {branches}")
assert branches.valid.sum() == 8

# The hand moves to one side, to the other, and back. Pose by pose, IK may run into a dead end; ``follow`` solves the whole path.
T_path = np.repeat(robot.forward_kinematics(robot.home)[None], 100, axis=0)
T_path[:, 1, 3] += 0.1 * np.sin(np.linspace(0, 2 * np.pi, 100))
path = robot.follow(T_path, robot.home)
print(f"a path: {path}")
assert path.success
assert np.abs(robot.forward_kinematics(path.q) - T_path).max() < 1e-4

q, dt = robot.home.copy(), 0.01
for _ in range(100):
    q += dt * robot.differential_ik(q, [0.1, 0, 0, 0, 0, 0], dt)
moved = robot.forward_kinematics(q)[:3, 3] - robot.forward_kinematics(robot.home)[:3, 3]
print(f"a second at 0.1 m/s: {moved.round(4)}")
assert np.abs(moved - [0.1, 0, 0]).max() < 1e-3
