"""Measures a solver of inverse kinematics: how many targets it solves, and how long each call takes."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.bench.arms import path_positions
from ulna.bench.protocol import PROTOCOLS, Protocol, pose_errors, within_limits
from ulna.bench.timing import time_each
from ulna.robot import Robot

Array = NDArray[np.float64]
Forward = Callable[[Array], Array]
STEP_BOUND = 0.1  # rad or m, from one pose of a path to the next; another branch is further away


class Solver(NamedTuple):
    """A solver: ``solve(prepare(T), start)``, where start is a q or None; ``q_of`` takes q from its result, None if not solved.

    Only ``solve`` is timed.
    """

    name: str
    solve: Callable
    q_of: Callable
    prepare: Callable = lambda T: T


def ulna_solver(robot: Robot, protocol: Protocol) -> Solver:
    """Ulna: one public call for each target."""
    position, rotation = protocol.tolerances

    def solve(T, start):
        return robot.inverse_kinematics(
            T, start, position_tolerance=position, rotation_tolerance=rotation, max_iterations=protocol.max_iterations
        )

    return Solver("ulna", solve, lambda found: found.q if found.success else None)


def run_protocol(solver: Solver, robot: Robot, name: str, n: int, forward: Forward, passes: int = 3) -> dict[str, object]:
    """A row of the table: of n targets those that the solver reports solved and ``forward`` (q to T) confirms, and times."""
    protocol = PROTOCOLS[name]
    targets, start = protocol.targets(robot, n), protocol.start(robot)
    claimed, good = judge(solver, robot, protocol, targets, forward)
    times = time_each(solver.solve, [(solver.prepare(T), start) for T in targets], passes)
    return {"robot": robot.name, "protocol": name, "solver": solver.name, **solver_figures(claimed, good, times)}


def solver_figures(claimed: NDArray[np.bool_], good: NDArray[np.bool_], times_ns: Array) -> dict[str, float]:
    """Figures of a solver: whether it claimed each target, whether that was right, and the times of its calls [ns]."""
    return {
        "targets": len(good),
        "solved_percent": 100.0 * float(good.mean()),
        "said_solved_but_not": int(np.count_nonzero(claimed & ~good)),
        "mean_us": float(times_ns.mean()) / 1e3,
        "median_us": float(np.median(times_ns)) / 1e3,
        "p99_us": float(np.percentile(times_ns, 99)) / 1e3,
    }


def judge(
    solver: Solver, robot: Robot, protocol: Protocol, targets: Array, forward: Forward
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """For each target whether the solver reports it solved, and whether it is: two arrays of shape (n,)."""
    start = protocol.start(robot)
    found = [solver.q_of(solver.solve(solver.prepare(T), start)) for T in targets]
    claimed = np.array([q is not None for q in found])
    q = np.array([robot.home if q is None else q for q in found])
    reached = protocol.reached(pose_errors(forward(q), targets))
    return claimed, claimed & reached & within_limits(robot, q)


def follow_path(solver: Solver, robot: Robot, n: int, forward: Forward) -> dict[str, object]:
    """A row of the table of tracking: n poses of a smooth path, each search started from the solution before."""
    path = path_positions(robot, n, seed=1)
    targets, q = robot.forward_kinematics(path), path[0]
    found = np.empty_like(path)
    lost = 0
    for k, T in enumerate(targets):
        solution = solver.q_of(solver.solve(solver.prepare(T), q))
        lost += solution is None
        found[k] = q = q if solution is None else solution
    steps = np.abs(np.diff(found, axis=0)).max(axis=1)
    reached = PROTOCOLS["reachable"].reached(pose_errors(forward(found), targets)) & within_limits(robot, found)
    times = time_each(solver.solve, list(zip(map(solver.prepare, targets[1:]), found[:-1], strict=True))) / 1e3
    return {
        "robot": robot.name,
        "solver": solver.name,
        "poses": n,
        "solved_percent": 100.0 * float(reached.mean()),
        "lost": lost,
        "path_step": float(np.abs(np.diff(path, axis=0)).max()),
        "largest_step": float(steps.max()),
        "steps_above_bound": int(np.count_nonzero(steps > STEP_BOUND)),
        "mean_us": float(times.mean()),
        "p99_us": float(np.percentile(times, 99)),
    }
