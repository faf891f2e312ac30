"""A solver of inverse kinematics under a protocol, or along a path: how many targets it solves, and how long each call takes."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.bench.protocol import PROTOCOLS, Protocol, pose_errors, within_limits
from ulna.bench.targets import path_positions
from ulna.bench.timing import time_each
from ulna.robot import Robot

Array = NDArray[np.float64]
Forward = Callable[[Array], Array]
STEP_BOUND = 0.1  # rad or m, from one pose of a path to the next: a branch that flips is further away


class Solver(NamedTuple):
    """What solves: ``solve(prepare(T), start)`` with start a q or None; ``answer`` takes the q from what that returns, or None.

    Only ``solve`` is timed.
    """

    name: str
    solve: Callable
    answer: Callable
    prepare: Callable = lambda T: T


def ulna_solver(robot: Robot, protocol: Protocol) -> Solver:
    """Ulna itself, one whole call for a target."""
    position, rotation = protocol.tolerances

    def solve(T, start):
        return robot.inverse_kinematics(
            T, start, position_tolerance=position, rotation_tolerance=rotation, max_iterations=protocol.max_iterations
        )

    return Solver("ulna", solve, lambda found: found.q if found.success else None)


def run_protocol(solver: Solver, robot: Robot, name: str, n: int, forward: Forward, passes: int = 3) -> dict[str, object]:
    """A row of the table: what the solver says of n targets, what ``forward`` (q to T) says of its answers, and its times."""
    protocol = PROTOCOLS[name]
    targets, start = protocol.targets(robot, n), protocol.start(robot)
    claimed, good = judge(solver, robot, protocol, targets, forward)
    times = time_each(solver.solve, [(solver.prepare(T), start) for T in targets], passes)
    return {"robot": robot.name, "protocol": name, "solver": solver.name, **solver_figures(claimed, good, times)}


def solver_figures(claimed: NDArray[np.bool_], good: NDArray[np.bool_], times_ns: Array) -> dict[str, float]:
    """What is told of a solver: of n targets each, what it said, whether it was so, and the times of its calls [ns]."""
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
    """For each target whether the solver says that it is solved, and whether it is."""
    start = protocol.start(robot)
    answers = [solver.answer(solver.solve(solver.prepare(T), start)) for T in targets]
    claimed = np.array([q is not None for q in answers])
    q = np.array([robot.home if q is None else q for q in answers])
    reached = protocol.reached(pose_errors(forward(q), targets))
    return claimed, claimed & reached & within_limits(robot, q)


def follow_path(solver: Solver, robot: Robot, n: int, forward: Forward) -> dict[str, object]:
    """A row of the table of tracking: n poses of a smooth path, each search started at the answer before."""
    path = path_positions(robot, n, seed=1)
    targets, q = robot.forward_kinematics(path), path[0]
    answers = np.empty_like(path)
    lost = 0
    for k, T in enumerate(targets):
        answer = solver.answer(solver.solve(solver.prepare(T), q))
        lost += answer is None
        answers[k] = q = q if answer is None else answer
    steps = np.abs(np.diff(answers, axis=0)).max(axis=1)
    reached = PROTOCOLS["reachable"].reached(pose_errors(forward(answers), targets)) & within_limits(robot, answers)
    times = time_each(solver.solve, list(zip(map(solver.prepare, targets[1:]), answers[:-1], strict=True))) / 1e3
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
