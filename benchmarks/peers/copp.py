"""Times the path of a motion with copp-py (MIT, ``pip install copp-py``): TOPP2 without a limit of jerk, TOPP3 with one."""

import time

import copp_py
import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.peer import NotForThisArm

STATIONS = 800  # along the path, between equal times and equal lengths of the motion
REFINED = 2  # times that the third-order problem is linearised about its last solution
SLOW = 1e-3  # of the greatest speed: slower than that, at its ends, a motion is on a line

Array = NDArray[np.float64]


def durations(motion: ulna.Trajectory, velocity: Array, acceleration: Array, jerk: Array) -> dict[str, tuple[float, float]]:
    """The durations [s] and the thread's time [s] of TOPP2 and of TOPP3 along the path of a motion, at rest at both ends.

    Raises:
        NotForThisArm: A solver finds no motion; its own words.
    """
    s, derivatives = along(motion)
    whole = {"start_idx_s": 0, "length": STATIONS}
    began = time.thread_time()
    robot = copp_py.Robot(motion.q.shape[1], capacity=STATIONS)
    robot.append_s(s)
    robot.set_q(*derivatives[:3], 0, dddq=derivatives[3])
    robot.add_velocity_limits(velocity, -velocity, **whole)
    robot.add_acceleration_limits(acceleration, -acceleration, **whole)
    robot.add_jerk_limits(jerk, -jerk, **whole)
    second, third, found = copp_py.solver.topp2_ra, copp_py.solver.topp3_lp, {}
    try:
        a = second.solve(second.Problem(robot.constraints, (0, STATIONS - 1)))
        found["TOPP2"] = copp_py.interpolation.s_to_t_topp2(s, a)[0], time.thread_time() - began
        robot.constraints.amax_substitute(a, 0)
        b = None
        for _ in range(1 + REFINED):
            profile = third.solve(third.Problem(robot.constraints, a, b_linearization=b))
            a, b = np.maximum(profile.a, 0), profile.b
            found["TOPP3"] = copp_py.interpolation.s_to_t_topp3(s, profile)[0], time.thread_time() - began
    except (copp_py.CoppError, ValueError) as error:
        if "TOPP3" not in found:
            raise NotForThisArm(str(error)) from None
    return found


def along(motion: ulna.Trajectory) -> tuple[Array, list[Array]]:
    """The length along the path at STATIONS moments, shape (STATIONS,), and q with its first three derivatives by it."""
    fine = np.linspace(0, motion.duration, 20 * STATIONS)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(motion.at(fine).q, axis=0), axis=1))])
    t = np.interp(np.linspace(0, 2, STATIONS), fine / fine[-1] + length / length[-1], fine)
    q, qd, qdd, qddd = motion.at(t)
    speed = np.linalg.norm(qd, axis=1)
    moves = speed > SLOW * speed.max()
    v = np.where(moves, speed, 1)
    grows = (qd * qdd).sum(axis=1) / v
    bends = ((qdd * qdd + qd * qddd).sum(axis=1) - grows**2) / v
    first = qd / v[:, None]
    second = (qdd - first * grows[:, None]) / v[:, None] ** 2
    third = (qddd - 3 * (v * grows)[:, None] * second - first * bends[:, None]) / v[:, None] ** 3
    inside = np.flatnonzero(moves)
    first[: inside[0]], first[inside[-1] + 1 :] = first[inside[0]], first[inside[-1]]
    second[~moves], third[~moves] = 0, 0
    return np.interp(t, fine, length), [q, first, second, third]
