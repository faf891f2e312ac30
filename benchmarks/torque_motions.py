"""Computes motions within torque limits along the paths of VAMP's problems, judged by Pinocchio, next to copp-py.

The paths are those of ``robot.plan`` for VAMP's spheres and objects. The bundled Panda follows each, with and without a point
mass at its tip, as fast as its limits of velocity and effort allow. copp-py gets the same lines and parabolas with the same
limits; it takes its torques from Pinocchio, one call at a time. Its q'' at a station is the value after the station.
"""

import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import ulna
from benchmarks.peer import NotForThisArm
from benchmarks.peers.pinocchio_forces import Forces
from benchmarks.plans import within_limits
from benchmarks.vamp_problems import read_problems, spheres
from ulna.errors import InputError

Array = NDArray[np.float64]
PAYLOADS = 0.0, 3.0  # [kg]
ACCELERATION = 15.0  # [rad/s^2]
WITHIN = 0.02  # [rad]: maximum deviation of a rounded corner from the path
PERIOD = 1e-4  # [s], of the judged samples
FINER = 4  # stations of copp-py in each of our intervals
_PASSES = 3


class Stations(NamedTuple):
    """A path q(s) from rest to rest at samples: s, shape (n,); q, q' and q'', shape (n, n_dof) each."""

    s: Array
    q: Array
    slopes: Array
    bends: Array


class MostOf(NamedTuple):
    """The maximum velocity, acceleration and torque of each joint, shape (n_dof,) each."""

    velocity: Array
    acceleration: Array
    torque: Array


LeastTime = Callable[[Stations, MostOf, Callable[[Array, Array, Array], Array]], float]


class Compared(NamedTuple):
    """The figures of one path, or of many as arrays."""

    beyond: Any
    """The number of samples, 10,000 per second, with a torque beyond its limit."""
    share: Any
    """The maximum torque as a share of its limit."""
    duration: Any
    """The duration [s] of the motion within torque limits, of one without them, and of copp-py's."""
    without: Any
    of_copp: Any
    seconds: Any
    """The computation time of each of these three [s]."""
    seconds_without: Any
    seconds_of_copp: Any


def motion_rows(arm: ulna.Robot, folder: Path, every: int = 1) -> list[dict]:
    """A row for each payload."""
    copp = least_time()
    with ulna.threads(1):
        paths = list(paths_of(folder, arm, every))
        return [payload_row(arm, paths, mass, copp) for mass in PAYLOADS]


def least_time() -> LeastTime | None:
    """The function that computes the time of a path by copp-py; None, after printing the reason, if unavailable."""
    try:
        from benchmarks.peers import copp  # noqa: PLC0415 - it may be absent

        copp.refuse_another_time()
    except ImportError as error:
        sys.stderr.write(f"copp-py is absent: {error}\n")
    except NotForThisArm as reason:
        sys.stderr.write(f"copp-py: {reason}\n")
    else:
        return copp.least_time
    return None


def paths_of(folder: Path, arm: ulna.Robot, every: int) -> Iterator[Array]:
    """The path of each problem that has one."""
    robot = spheres(folder)
    for given in read_problems(folder, robot.joint_names)[::every]:
        problem, world = within_limits(robot, given), given.world()
        if problem is None or robot.in_collision([problem.start, problem.goal], world).any():
            continue
        plan = robot.plan(problem.start, problem.goal, world)
        if plan:
            yield np.clip(plan.path, arm.lower, arm.upper)


def payload_row(arm: ulna.Robot, paths: list[Array], mass: float, copp: LeastTime | None) -> dict:
    """The number of motions, their torques, their durations and their computation times."""
    robot = arm.with_tool(np.eye(4), name="payload", mass=mass) if mass else arm
    forces, found = Forces(robot), []
    for path in paths:
        try:
            made = compared(robot, path, forces, copp)
        except InputError as reason:
            sys.stderr.write(f"{mass:g} kg: {reason}\n")
            continue
        found.append(made)
    if not found:
        return {"payload kg": mass, "paths": len(paths), "motions": 0}
    all_of = Compared(*(np.array(each) for each in zip(*found, strict=True)))
    ratios = all_of.duration / all_of.of_copp
    return {
        "payload kg": mass,
        "paths": len(paths),
        "motions": len(found),
        "slower by torques": int((all_of.duration > 1.001 * all_of.without).sum()),
        "beyond at 10 kHz": int(all_of.beyond.sum()),
        "greatest share": float(all_of.share.max()),
        "computed in ms": 1e3 * float(np.median(all_of.seconds)),
        "without torques ms": 1e3 * float(np.median(all_of.seconds_without)),
        "copp-py ms": 1e3 * float(np.median(all_of.seconds_of_copp)),
        "time, of copp-py's": float(all_of.duration.sum() / all_of.of_copp.sum()),
        "median": float(np.median(ratios)),
        "most": float(ratios.max()),
    }


def compared(robot: ulna.Robot, path: Array, forces: Forces, copp: LeastTime | None) -> Compared:
    """The motion along a path within torque limits, without them, and by copp-py; each computed several times, interleaved.

    Raises:
        InputError: The motors cannot hold the robot still on the path.
    """
    most = MostOf(robot.velocity_limits, np.full(robot.n_dof, ACCELERATION), robot.effort_limits)
    limited, free = (
        partial(robot.trajectory, path, within=WITHIN, acceleration=most.acceleration, torque=torque)
        for torque in (most.torque, None)
    )
    motion, without = limited(), free()
    sections = list(stations_of(motion))
    call = forces.calls["inverse_dynamics"]

    def by_copp() -> float:
        return np.nan if copp is None else sum(copp(section, most, lambda *x: call(x)) for section in sections)

    beyond, share = judged(motion, forces, most.torque)
    seconds = np.min([[_seconds(work) for work in (limited, free, by_copp)] for _ in range(_PASSES)], axis=0)
    return Compared(beyond, share, motion.duration, without.duration, by_copp(), *seconds)


def judged(motion: ulna.Trajectory, forces: Forces, most: Array) -> tuple[int, float]:
    """The number of a motion's samples with a torque beyond a limit, and the maximum share of a limit."""
    moments = motion.at(np.append(np.arange(0.0, motion.duration, PERIOD), motion.duration))
    shares = (np.abs(forces.torques(*moments[:3])) / most).max(axis=1)
    return int((shares > 1.0).sum()), float(shares.max())


def stations_of(motion: ulna.Trajectory) -> Iterator[Stations]:
    """The path of a motion between its stops, with FINER stations in each of its own intervals."""
    grid = motion._timed.grid  # noqa: SLF001 - our own
    for first, last in pairwise(grid.borders):
        of = np.append(np.repeat(np.arange(first, last), FINER), last - 1)
        shares = np.append(np.tile(np.arange(FINER) / FINER, last - first), 1.0)
        lengths = np.concatenate([[0.0], np.cumsum(grid.steps[first:last])])
        s = (shares * grid.steps[of])[:, None]
        slopes = grid.slopes[of] + s * grid.bends[of]
        q = grid.starts[of] + s * (grid.slopes[of] + 0.5 * s * grid.bends[of])
        yield Stations(lengths[of - first] + s[:, 0], q, slopes, grid.bends[of])


def _seconds(work: Callable[[], object]) -> float:
    began = time.thread_time()
    work()
    return time.thread_time() - began
