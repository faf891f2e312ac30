"""Measures a solver of inverse kinematics: targets, start, criterion of success, and the time of each call.

``ulna bench ik`` runs these protocols on Ulna, ``make bench`` on the peers too. A solver's own status is not trusted. Its q must
be within the limits, and an independent forward kinematics must confirm that it reaches the target.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.bench.arms import middle, out_of_reach, path_positions, random_positions
from ulna.bench.timing import time_each
from ulna.robot import Robot

Array = NDArray[np.float64]
Forward = Callable[[Array], Array]
STEP_BOUND = 0.1  # rad or m, between neighboring poses of a path; another branch is farther away
_SLACK = 1.001  # solvers compare with the tolerance in their own rounding
_LIMIT_SLACK = 1e-6  # rad or m: some peers store limits as float32


class Protocol(NamedTuple):
    """Targets, start and tolerances for a solver.

    Attributes:
        source: The source of the protocol.
        reached: Maps errors, shape (n, 6), position [m] and rotation vector [rad], to whether the targets count as reached, shape
            (n,).
        reachable: Whether all targets are within reach; if not, all are beyond it.
        from_middle: Whether the search starts from the middle of the range; if not, the solver chooses its start.
        tolerances: Distance [m] and angle [rad], for a solver that takes these two.
        component: The tolerance for a solver that compares each of six components with one number [m and rad].
        max_iterations: The maximum number of steps; None for the solver's default.
    """

    source: str
    reached: Callable[[Array], NDArray[np.bool_]]
    reachable: bool = True
    from_middle: bool = False
    tolerances: tuple[float, float] = (1e-5, 1e-5)
    component: float = 1e-5 / 3**0.5
    max_iterations: int | None = None

    def targets(self, robot: Robot, n: int, seed: int = 0) -> Array:
        """Targets, shape (n, 4, 4)."""
        if not self.reachable:
            return out_of_reach(robot, n, seed)
        return robot.forward_kinematics(random_positions(robot, n, seed))

    def start(self, robot: Robot) -> Array | None:
        """The start q of the search [rad or m], shape (n_dof,), or None."""
        return middle(robot) if self.from_middle else None


def _within_distance_and_angle(errors: Array) -> NDArray[np.bool_]:
    return (np.linalg.norm(errors[:, :3], axis=1) <= 1e-5 * _SLACK) & (np.linalg.norm(errors[:, 3:], axis=1) <= 1e-5 * _SLACK)


def _within_each_component(errors: Array) -> NDArray[np.bool_]:
    return np.abs(errors).max(axis=1) <= 1e-5 * _SLACK


def _within_half_square(errors: Array) -> NDArray[np.bool_]:
    return np.square(errors).sum(axis=1) / 2 <= 1e-6 * _SLACK


PROTOCOLS = {
    "reachable": Protocol("Ulna: 1e-5 m and 1e-5 rad", _within_distance_and_angle),
    "A": Protocol(
        "TRAC-IK (Beeson and Ames, Humanoids 2015): 1e-5 a component", _within_each_component, from_middle=True, component=1e-5
    ),
    "B": Protocol(
        "Robotics Toolbox (Haviland and Corke, 2022): e'e / 2 < 1e-6, 100 searches of 30 steps",
        _within_half_square,
        tolerances=(1e-3, 1e-3),
        component=1e-3 / 3**0.5,
        max_iterations=3000,
    ),
    "unreachable": Protocol("Ulna: beyond the longest reach", _within_distance_and_angle, reachable=False),
}


def pose_errors(T: Array, targets: Array) -> Array:
    """Errors of poses T to targets, both (n, 4, 4): position [m] and rotation vector [rad], shape (n, 6).

    They are in the axes of T, in which TRAC-IK compares each component with its tolerance. Lengths do not depend on the axes.
    """
    back = np.swapaxes(T[:, :3, :3], 1, 2)
    R = back @ targets[:, :3, :3]
    sine = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    size = np.linalg.norm(sine, axis=1, keepdims=True)
    angle = np.arctan2(size[:, 0], (np.trace(R, axis1=1, axis2=2) - 1) / 2)[:, None]
    axis = np.where(size > 0, sine, [1.0, 0.0, 0.0]) / np.where(
        size > 0, size, 1.0
    )  # any axis, without rotation or for half a turn
    way = (back @ (targets[:, :3, 3] - T[:, :3, 3])[:, :, None])[:, :, 0]
    return np.concatenate([way, axis * angle], axis=1)


def within_limits(robot: Robot, q: Array) -> NDArray[np.bool_]:
    """Whether each row of q, shape (n, n_dof), is within all limits, shape (n,)."""
    return np.all((q >= robot.lower - _LIMIT_SLACK) & (q <= robot.upper + _LIMIT_SLACK), axis=1)


class Solver(NamedTuple):
    """A solver as three functions: ``solve(prepare(T), start)``, and ``q_of``, which extracts q or None.

    ``start`` is a q or None. Only ``solve`` is timed.
    """

    name: str
    solve: Callable
    q_of: Callable
    prepare: Callable = lambda T: T


def ulna_solver(robot: Robot, protocol: Protocol) -> Solver:
    """Ulna with one public call for each target."""
    position, rotation = protocol.tolerances

    def solve(T, start):
        return robot.inverse_kinematics(
            T, start, position_tolerance=position, rotation_tolerance=rotation, max_iterations=protocol.max_iterations
        )

    return Solver("ulna", solve, lambda found: found.q if found.success else None)


def run_protocol(solver: Solver, robot: Robot, name: str, n: int, forward: Forward, passes: int = 3) -> dict[str, object]:
    """A row of the table: times, and the share of n targets that ``forward`` (q to T) confirms as solved."""
    protocol = PROTOCOLS[name]
    targets, start = protocol.targets(robot, n), protocol.start(robot)
    claimed, good = judge(solver, robot, protocol, targets, forward)
    times = time_each(solver.solve, [(solver.prepare(T), start) for T in targets], passes)
    return {"robot": robot.name, "protocol": name, "solver": solver.name, **solver_figures(claimed, good, times)}


def solver_figures(claimed: NDArray[np.bool_], good: NDArray[np.bool_], times_ns: Array) -> dict[str, float]:
    """Figures of a solver from its claims, their correctness, and the times of its calls [ns]."""
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
    """Whether the solver claims each target, and whether it solved it: two arrays of shape (n,)."""
    start = protocol.start(robot)
    found = [solver.q_of(solver.solve(solver.prepare(T), start)) for T in targets]
    claimed = np.array([q is not None for q in found])
    q = np.array([robot.home if q is None else q for q in found])
    reached = protocol.reached(pose_errors(forward(q), targets))
    return claimed, claimed & reached & within_limits(robot, q)


def follow_path(solver: Solver, robot: Robot, n: int, forward: Forward) -> dict[str, object]:
    """A row of the tracking table: n poses of a smooth path, each search started from the solution before."""
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
