"""``frankik``: closed form for the Panda (He and Liu 2021), which tries sixty values of the last joint.

It takes poses of the flange turned as the hand is; that offset is taken off beforehand, and is not timed.
"""

import numpy as np
from frankik import FrankaKinematics, RobotType, fk

from benchmarks.peer import NotForThisArm, Peer, standing_offset
from ulna.bench.protocol import Protocol
from ulna.bench.solver import Solver
from ulna.robot import Robot


def make(robot: Robot) -> Peer:
    """The peer for the Panda."""
    if robot.name != "panda":
        raise NotForThisArm("for the Panda only")
    arm, T_tip_flange = FrankaKinematics(RobotType.PANDA), standing_offset(robot, fk)
    T_flange_tip = np.linalg.inv(T_tip_flange)

    def solver(_: Protocol) -> Solver:
        def solve(T, start):
            return arm.inverse(T, q0=start, global_solution=True)

        return Solver("frankik", solve, lambda q: q, lambda T: T @ T_tip_flange)

    return Peer(forward=lambda q: fk(q) @ T_flange_tip, solver=solver)
