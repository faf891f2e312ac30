"""Prints True if both forward kinematics agree: URDF and DH table, at home, zero and random joints."""

import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends the script without a traceback, even during the imports

import numpy as np
from panda import HOME, make_robot

if __name__ == "__main__":
    robot = make_robot()
    joints = [HOME, np.zeros(7), *np.random.default_rng(0).uniform(robot.lower, robot.upper, (100, 7))]
    print(all(np.allclose(robot.forward_kinematics_urdf(q), robot.forward_kinematics_dh(q), rtol=0, atol=1e-12) for q in joints))
