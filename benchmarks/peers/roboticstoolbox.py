"""Runs Robotics Toolbox (``roboticstoolbox-python``): its compiled element sequence, and ``ik_LM`` in C++.

Its tolerance is on e'e / 2, with e the position error and the rotation vector together: 5e-11 stands for 1e-5. It restarts from
random configurations up to 100 times, 30 steps each, and wraps results into the limits itself. The damping is Chan's with the
gain 0.1: of the methods and gains in its documentation this was the fastest on the Panda and on the UR5.
"""

import warnings

from benchmarks.peer import Peer
from ulna.bench.protocol import Protocol, Solver
from ulna.kernels.layout import COLUMN, FIXED, KIND, REVOLUTE
from ulna.kinematics.sample import usual_range
from ulna.kinematics.tree import row_pose
from ulna.robot import Robot

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from roboticstoolbox import ET, ETS

_GAIN = 0.1


def sequence(robot: Robot) -> ETS:
    """The arm's table of joints as an elementary transform sequence."""
    lower, upper = usual_range(robot.lower, robot.upper)
    elements = []
    for row in robot.tree.chain(robot.tip):
        elements.append(ET.SE3(row_pose(row)))
        if row[KIND] != FIXED:
            k = int(row[COLUMN])
            elements.append((ET.Rz if row[KIND] == REVOLUTE else ET.tz)(qlim=[lower[k], upper[k]]))
    return ETS(elements).compile()


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    ets = sequence(robot)

    def solver(protocol: Protocol) -> Solver:
        tol = 1e-6 if protocol.max_iterations else 0.5 * protocol.tolerances[0] ** 2

        def solve(T, start):
            return ets.ik_LM(T, q0=start, ilimit=30, slimit=100, tol=tol, k=_GAIN)

        return Solver("roboticstoolbox-python", solve, lambda found: found.q if found.success else None)

    return Peer(forward=ets.eval, jacobian=ets.jacob0, solver=solver)
