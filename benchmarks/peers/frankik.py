"""Runs ``frankik``: closed form for the Panda (He and Liu 2021), which tries sixty values of the last joint.

Its ``fk`` returns the pose of the hand's tip, its ``inverse`` takes that of the flange: the offset is removed beforehand, and is
not timed. (The offset that it ships is rounded to three digits.)
"""

import numpy as np
from frankik import FrankaKinematics, RobotType, fk

from benchmarks.peer import NotForThisArm, Peer, standing_offset
from ulna.bench.protocol import Protocol, Solver
from ulna.description.pose import pose
from ulna.robot import Robot

_FLANGE_HAND = pose((0.0, 0.0, 0.1034), (0.0, 0.0, -np.pi / 4))


def make(robot: Robot) -> Peer:
    """The peer for the Panda."""
    if robot.name != "panda":
        raise NotForThisArm("for the Panda only")
    arm, T_tip_end = FrankaKinematics(RobotType.PANDA), standing_offset(robot, fk)
    T_end_tip = np.linalg.inv(T_tip_end)
    T_tip_flange = T_tip_end @ np.linalg.inv(_FLANGE_HAND)

    def solver(_: Protocol) -> Solver:
        def solve(T, start):
            return arm.inverse(T, q0=start, global_solution=True)

        return Solver("frankik", solve, lambda q: q, lambda T: T @ T_tip_flange)

    return Peer(forward=lambda q: fk(q) @ T_end_tip, solver=solver)
