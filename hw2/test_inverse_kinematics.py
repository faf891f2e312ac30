"""Prints True if the joints that inverse kinematics finds for a pose bring the end-effector there."""

import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends the script without a traceback, even during the imports

import numpy as np
from panda import HOME, make_robot

if __name__ == "__main__":
    robot = make_robot()
    desired = robot.ee(HOME)
    desired[1] += 0.01
    joints = robot.inverse_kinematics(desired, HOME)
    print(np.allclose(robot.ee(joints), desired))
