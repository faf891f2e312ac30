"""Runs TRAC-IK by ``pytracik``: two searches in two threads, the first result wins, within 5 ms (its default).

Its tolerance is on each component of the error, in the axes of the tip. Its input quaternion is computed beforehand, and is not
timed.
"""

import pytracik

from benchmarks.peer import Peer, bare_urdf
from ulna.bench.arms import middle
from ulna.bench.protocol import Protocol, Solver
from ulna.description.pose import quaternion_from_matrix
from ulna.robot import Robot

_TIMEOUT_S = 0.005


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    text, at_middle = bare_urdf(robot), middle(robot)
    plain = pytracik.TRAC_IK(robot.base, robot.tip, text, _TIMEOUT_S, 1e-5, pytracik.SolveType.Speed)

    def solver(protocol: Protocol) -> Solver:
        search = pytracik.TRAC_IK(robot.base, robot.tip, text, _TIMEOUT_S, protocol.component, pytracik.SolveType.Speed)

        def prepare(T):
            w, x, y, z = quaternion_from_matrix(T[:3, :3])
            return (*T[:3, 3], x, y, z, w)

        def solve(target, start):
            return pytracik.ik(search, at_middle if start is None else start, *target)

        return Solver("pytracik", solve, lambda found: found[1:] if found[0] >= 0 else None, prepare)

    return Peer(forward=lambda q: pytracik.fk(plain, q), solver=solver)
