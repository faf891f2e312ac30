"""Runs ``ssik``: every branch in closed form for 6R arms, over samples of the redundancy for 7R arms.

It returns one solution here. Arms that it specializes in seconds are built from the same URDF; the Panda, which takes minutes, is
the one it ships.
"""

import numpy as np
import ssik

from benchmarks.peer import NotForThisArm, Peer, bare_urdf, standing_offset, urdf_file
from ulna.bench.protocol import Protocol, Solver
from ulna.robot import Robot

_QUICKLY_BUILT = ("ur5", "ur10", "z1_description", "kuka_lbr_iiwa_14_r820")


def arm_for(robot: Robot) -> ssik.Manipulator:
    """The library's own object for an arm."""
    if robot.name == "panda":
        return ssik.Manipulator.from_prebuilt("panda")
    if robot.name not in _QUICKLY_BUILT:
        raise NotForThisArm("not shipped with this geometry, and specializing it takes minutes")
    return build(robot)


def build(robot: Robot) -> ssik.Manipulator:
    """The arm specialized from its URDF."""
    with urdf_file(bare_urdf(robot)) as path:
        return ssik.Manipulator.from_urdf(path, base=robot.base, ee=robot.tip)


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    arm = arm_for(robot)
    T_tip_end = standing_offset(robot, arm.fk)
    T_end_tip = np.linalg.inv(T_tip_end)

    def solver(_: Protocol) -> Solver:
        def solve(T, start):
            return arm.solve(T, max_solutions=1, q_seed=start)

        return Solver("ssik", solve, lambda found: found[0].q if found else None, lambda T: T @ T_tip_end)

    return Peer(forward=lambda q: arm.fk(q) @ T_end_tip, solver=solver)
