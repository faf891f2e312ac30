"""Runs ``EAIK``: every branch in closed form for 6R arms of known families.

It knows no limits. The first branch within them is taken, shifted by whole turns if necessary, and that is not timed. Without a
solution it returns the nearest in the sense of least squares, and marks it; such branches are omitted.
"""

import numpy as np
from eaik.IK_URDF import UrdfRobot

from benchmarks.peer import NotForThisArm, Peer, bare_urdf, standing_offset, urdf_file, within_limits_by_turns
from ulna.bench.protocol import Protocol, Solver
from ulna.robot import Robot


def build(robot: Robot) -> UrdfRobot:
    """The library's own object for an arm."""
    if robot.n_dof != 6:
        raise NotForThisArm("for arms of six joints")
    with urdf_file(bare_urdf(robot)) as path:
        arm = UrdfRobot(path)
    if not arm.hasKnownDecomposition():
        raise NotForThisArm(f"no closed form: {arm.getKinematicFamily()}")
    return arm


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    arm = build(robot)
    T_tip_end = standing_offset(robot, arm.fwdKin)
    T_end_tip = np.linalg.inv(T_tip_end)

    def answer(found):
        turned = (within_limits_by_turns(robot, q) for q, near in zip(found.Q, found.is_LS, strict=True) if not near)
        return next((q for q in turned if q is not None), None)

    def solver(_: Protocol) -> Solver:
        return Solver("EAIK", lambda T, _: arm.IK(T), answer, lambda T: T @ T_tip_end)

    return Peer(forward=lambda q: arm.fwdKin(q) @ T_end_tip, solver=solver)
