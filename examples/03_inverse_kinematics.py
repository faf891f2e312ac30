"""Solves inverse kinematics for a pose one centimeter away, with a trace, and for a target out of reach."""

import sys

import ulna

robot = ulna.load("panda")
target = robot.forward_kinematics(robot.home)
target[1, 3] += 0.01  # from home, one centimeter along y

found = robot.inverse_kinematics(target, robot.home, position_tolerance=1e-10, rotation_tolerance=1e-10, trace=True)
print(f"from home: {found}")
for step, (position_error, rotation_error, largest, damping) in enumerate(found.trace):
    print(f"  step {step}: {position_error:.0e} m, {rotation_error:.0e} rad; moved {largest:.0e} rad; damping {damping:.0e}")
assert found.success
assert abs(robot.forward_kinematics(found.q) - target).max() < 1e-9

target[0, 3] = 2.0  # two meters away: beyond the reach of the arm
found = robot.inverse_kinematics(target)
print(f"out of reach: {found}")
assert not found.success
assert (robot.lower <= found.q).all()
assert (found.q <= robot.upper).all()

if "--view" in sys.argv:
    with ulna.view(robot, open_browser=True) as view:
        print(f"{view.url}: drag the hand, also out of reach; Ctrl-C ends", flush=True)
        view.wait()
