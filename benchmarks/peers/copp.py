"""Runs copp-py: the shortest time of a path within limits of velocity, acceleration and torque, by TOPP2 (TOPP-RA)."""

from collections.abc import Callable

import copp_py as copp
import numpy as np
from numpy.typing import NDArray

from benchmarks.peer import NotForThisArm
from benchmarks.torque_motions import MostOf, Stations

Array = NDArray[np.float64]


def least_time(path: Stations, most: MostOf, inverse_dynamics: Callable[[Array, Array, Array], Array]) -> float:
    """The time [s] that copp-py computes for a path. inverse_dynamics: torques of one q and its two rates."""
    n, n_dof = path.q.shape
    robot = copp.Robot(n_dof, capacity=n, inverse_dynamics=inverse_dynamics)
    robot.append_s(path.s)
    robot.set_q(path.q, path.slopes, path.bends, 0)
    adders = robot.add_velocity_limits, robot.add_acceleration_limits, robot.add_torque_limits
    for add, limit in zip(adders, most, strict=True):
        add(limit, -limit, start_idx_s=0, length=n)
    problem = copp.solver.topp2_ra.Problem(robot.constraints, idx_s_interval=(0, n - 1), a_boundary=(0.0, 0.0))
    return float(copp.interpolation.s_to_t_topp2(path.s, copp.solver.topp2_ra.solve(problem), 0.0)[0])


def refuse_another_time() -> None:
    """Refuse copp-py if it does not find a known time.

    A mass of 2 kg moves 1 m with at most 8 N: half of the way with 4 m/s^2, and half with -4 m/s^2, in 1 s.

    Raises:
        NotForThisArm: It finds another time.
    """
    s = np.linspace(0.0, 1.0, 1001)
    line = Stations(s, s[:, None], np.ones((1001, 1)), np.zeros((1001, 1)))
    seconds = least_time(line, MostOf(*np.array([[100.0], [100.0], [8.0]])), lambda _q, _qd, qdd: 2.0 * qdd)
    if abs(seconds - 1.0) > 1e-3:
        raise NotForThisArm(f"it needs {seconds:.4g} s where 1 s is the least")
