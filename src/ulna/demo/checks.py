"""Runs the checks of the assignment: each has a figure, its bound, and a verdict."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.demo.scenario import BOX, make_trajectory
from ulna.description.names import panda
from ulna.description.pose import angle_between, pose, rotation_vector_from_matrix, rpy_from_matrix
from ulna.description.shapes import Box
from ulna.robot import Robot, load

N_CONFIGURATIONS = 1000
N_TARGETS = 1000
N_BOX_CONFIGURATIONS = 300  # twelve pairs each; the reference implementation takes a third of a millisecond per pair
DIFFERENCE_STEP = 1e-5  # [rad]: rounding error and truncation error are about equal
MAX_STEPS, SHORTEST_STEP = 5000, 1e-12  # of the Jacobian transpose method
CONTACT = 1e-9  # [m], pairs with a smaller distance or depth are not compared: rounding decides


@dataclass(frozen=True)
class Check:
    """One line of the table."""

    name: str
    figure: str
    bound: str
    passed: bool


def run_checks(dh_rows: Sequence[Sequence[float]] = panda.DH_ROWS) -> Iterator[Check]:
    """Run all checks of the Panda in turn. ``dh_rows`` is the table compared with the URDF, shape (9, 4)."""
    robot = load("panda")
    dh_robot = Robot.from_dh(dh_rows, joint_types=panda.DH_JOINT_TYPES)
    rng = np.random.default_rng(2)
    q = np.vstack([robot.home, np.zeros(robot.n_dof), rng.uniform(robot.lower, robot.upper, (N_CONFIGURATIONS, robot.n_dof))])
    yield urdf_against_dh(robot, dh_robot, q)
    yield jacobian_against_differences(robot, q)
    yield analytical_jacobian_against_differences(robot, q)
    yield levenberg_marquardt_round_trips(robot, dh_robot, rng)
    yield jacobian_transpose_round_trip(robot, dh_robot)
    yield boxes_against_reference(robot, q[:N_BOX_CONFIGURATIONS], rng)
    yield closed_trajectory(robot)


def urdf_against_dh(robot: Robot, dh_robot: Robot, q: NDArray) -> Check:
    """Compare the forward kinematics of all nine frames from the URDF and from the DH table."""
    columns = [robot.link_names.index(name) for name in panda.DH_LINKS]
    difference = np.abs(robot.link_poses(q)[:, columns] - dh_robot.link_poses(q)[:, 1:]).max()
    return _bounded_check("forward kinematics, URDF against DH", difference, 1e-12, "", f"9 frames, {len(q)} configurations")


def jacobian_against_differences(robot: Robot, q: NDArray) -> Check:
    """Compare the geometric Jacobian with central differences of the pose."""
    differences = np.empty((len(q), 6, robot.n_dof))
    T = robot.forward_kinematics(q)
    for j, (ahead, behind) in enumerate(_neighbors(robot.forward_kinematics, q)):
        rate = (ahead - behind) / (2 * DIFFERENCE_STEP)
        W = rate[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2)  # R' R^T, the angular velocity as a skew matrix
        differences[:, :3, j] = rate[:, :3, 3]
        differences[:, 3:, j] = np.stack([W[:, 2, 1] - W[:, 1, 2], W[:, 0, 2] - W[:, 2, 0], W[:, 1, 0] - W[:, 0, 1]], axis=-1) / 2
    largest = np.abs(robot.jacobian(q) - differences).max()
    return _bounded_check("Jacobian against central differences", largest, 1e-8, "", f"{len(q)} configurations")


def analytical_jacobian_against_differences(robot: Robot, q: NDArray) -> Check:
    """Compare the rates of roll, pitch and yaw with central differences, away from gimbal lock."""
    q = q[np.abs(np.cos(rpy_from_matrix(robot.forward_kinematics(q))[:, 1])) > 0.1]
    differences = np.empty((len(q), 6, robot.n_dof))
    for j, (ahead, behind) in enumerate(_neighbors(robot.forward_kinematics, q)):
        turn = rpy_from_matrix(ahead) - rpy_from_matrix(behind)
        turn -= 2 * np.pi * np.round(turn / (2 * np.pi))
        differences[:, :3, j] = (ahead - behind)[:, :3, 3] / (2 * DIFFERENCE_STEP)
        differences[:, 3:, j] = turn / (2 * DIFFERENCE_STEP)
    largest = np.abs(robot.analytical_jacobian(q) - differences).max()
    return _bounded_check(
        "analytical Jacobian against differences", largest, 1e-5, "", f"{len(q)} configurations, |cos pitch| > 0.1"
    )


def levenberg_marquardt_round_trips(robot: Robot, dh_robot: Robot, rng: np.random.Generator) -> Check:
    """Solve random reachable targets, and verify the results with the forward kinematics of the DH table."""
    targets = robot.forward_kinematics(rng.uniform(robot.lower, robot.upper, (N_TARGETS, robot.n_dof)))
    robot.inverse_kinematics(targets[0])
    start = time.perf_counter()
    results = [robot.inverse_kinematics(T) for T in targets]
    mean = (time.perf_counter() - start) / N_TARGETS
    q = np.array([result.q for result in results])
    solved = int(np.count_nonzero(np.array([result.success for result in results]) & _reached(dh_robot, q, targets, 1.01e-5)))
    inside = bool(((q >= robot.lower) & (q <= robot.upper)).all())
    figure = f"{solved} of {N_TARGETS} solved, {mean * 1e6:.1f} us a call"
    return Check("inverse kinematics round trips", figure, "all, to 1e-5, within the limits", solved == N_TARGETS and inside)


def jacobian_transpose_round_trip(robot: Robot, dh_robot: Robot) -> Check:
    """Run the assignment's method on its example: from home, one centimeter along y."""
    target = robot.forward_kinematics(robot.home)
    target[1, 3] += 0.01
    q, e, steps = by_jacobian_transpose(robot, target, robot.home, 1e-10)
    off = max(np.linalg.norm(e[:3]), np.linalg.norm(e[3:]))
    passed = bool(off <= 1e-10 and _reached(dh_robot, q, target, 1.01e-10))
    return Check("inverse kinematics by Jacobian transpose", f"{off:.1e} after {steps} steps", "1e-10", passed)


def by_jacobian_transpose(robot: Robot, target: NDArray, q: NDArray, tolerance: float) -> tuple[NDArray, NDArray, int]:
    """Steepest descent from q: returns the final q, the remaining error [m, rad], shape (6,), and the number of steps.

    The step is alpha g with g = J' e, alpha = <e, J g> / <J g, J g>, halved until the error decreases. ``hw2/franka_robot.py``
    uses the same step. Joint limits are ignored here.
    """
    e = _pose_error(target, robot.forward_kinematics(q))
    for steps in range(MAX_STEPS):
        if max(np.linalg.norm(e[:3]), np.linalg.norm(e[3:])) <= tolerance:
            return q, e, steps
        J = robot.jacobian(q)
        g = J.T @ e
        Jg = J @ g
        alpha = (e @ Jg) / (Jg @ Jg)
        while True:
            tried = _pose_error(target, robot.forward_kinematics(q + alpha * g))
            if tried @ tried < e @ e:
                break
            alpha /= 2
            if alpha < SHORTEST_STEP:
                return q, e, steps
        q, e = q + alpha * g, tried
    return q, e, MAX_STEPS


def boxes_against_reference(robot: Robot, q: NDArray, rng: np.random.Generator) -> Check:
    """Compare kernel and reference on all twelve pairs at each configuration, with the movable box near the arm.

    Every tenth time a small box lies inside one of the arm's boxes, which counts as a collision too.
    """
    shapes = [body.shape for link in robot.description.links for body in link.collisions]
    poses = robot.collision_poses(q)
    wrong = touching = 0
    for k in range(len(q)):
        inside = k % 10 == 0
        place = poses[k, rng.integers(len(shapes)), :3, 3] + (0 if inside else rng.normal(scale=0.12, size=3))
        box, T = Box((0.01, 0.01, 0.01)) if inside else BOX, pose(place, rng.uniform(-np.pi, np.pi, 3))
        world = World()
        world.add("box", box, T)
        gaps = np.array([slow_gap(poses[k, i], shape, T, box) for i, shape in enumerate(shapes) if isinstance(shape, Box)])
        hits = {name for name, gap in zip(robot.collision_names, gaps, strict=True) if gap < 0}
        if np.abs(gaps).min() > CONTACT:
            touching += bool(hits)
            wrong += set(robot.check_collision(q[k], world, self_collision=False).touching) != hits
            wrong += bool(np.all(robot.in_collision(q[k : k + 1], world, self_collision=False))) != bool(hits)
    figure = f"{wrong} of {2 * len(q)} verdicts differ, {touching} of {len(q)} touch"
    return Check("boxes against a slow reference", figure, "none differ, a third touch", wrong == 0 and 3 * touching > len(q))


def closed_trajectory(robot: Robot) -> Check:
    """Check that the demo's trajectory ends at its start."""
    off = np.abs(make_trajectory(robot).samples[-1] - robot.home).max()
    return _bounded_check("trajectory closes at home", off, 1e-6, " rad", "90 samples")


def slow_gap(T_a: NDArray, a: Box, T_b: NDArray, b: Box) -> float:
    """The widest gap between the projections of two boxes on the fifteen axes [m], computed from their corners.

    A slow, independent implementation: it does not use the boxes' symmetry, all axes are unit vectors, and parallel edges give no
    axis.
    """
    signs = np.array(list(product((-1, 1), repeat=3)))
    corners_a, corners_b = (signs * s.half_extents @ T[:3, :3].T + T[:3, 3] for s, T in ((a, T_a), (b, T_b)))
    crosses = [np.cross(u, v) for u in T_a[:3, :3].T for v in T_b[:3, :3].T]
    axes = [*T_a[:3, :3].T, *T_b[:3, :3].T, *(c / np.linalg.norm(c) for c in crosses if np.linalg.norm(c) > CONTACT)]
    spans_a, spans_b = corners_a @ np.transpose(axes), corners_b @ np.transpose(axes)
    gaps = np.maximum(spans_a.min(axis=0) - spans_b.max(axis=0), spans_b.min(axis=0) - spans_a.max(axis=0))
    return float(gaps.max())


def _neighbors(function: Callable[[NDArray], NDArray], q: NDArray) -> Iterator[tuple[NDArray, NDArray]]:
    """The values of a function a small step ahead and behind, for each entry of q."""
    for j in range(q.shape[-1]):
        step = np.zeros(q.shape[-1])
        step[j] = DIFFERENCE_STEP
        yield function(q + step), function(q - step)


def _reached(robot: Robot, q: NDArray, targets: NDArray, tolerance: float) -> NDArray[np.bool_]:
    """Whether the poses at q, shape (n, n_dof), are within the tolerance of the targets: distance [m] and angle [rad]."""
    T = robot.forward_kinematics(q)
    away = np.linalg.norm((T - targets)[..., :3, 3], axis=-1)
    return (away <= tolerance) & (angle_between(T, targets) <= tolerance)


def _pose_error(target: NDArray, T: NDArray) -> NDArray:
    """The displacement [m] and the rotation vector [rad] from a pose to the target, in the base, shape (6,)."""
    return np.concatenate([target[:3, 3] - T[:3, 3], rotation_vector_from_matrix(target[:3, :3] @ T[:3, :3].T)])


def _bounded_check(name: str, value: float, bound: float, unit: str, over: str) -> Check:
    return Check(name, f"{value:.1e}{unit} ({over})", f"{bound:.0e}{unit}", bool(value <= bound))
