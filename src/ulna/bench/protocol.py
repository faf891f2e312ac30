"""Says how inverse kinematics is measured: the targets, the start, and what counts as reached.

``ulna bench ik`` runs these protocols on Ulna, ``make bench`` on the peers too. A solver's own status is not trusted: its q must
be within the limits, and reach the target by a forward kinematics that is not the solver's.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.bench.arms import middle, out_of_reach, random_positions
from ulna.robot import Robot

Array = NDArray[np.float64]
_SLACK = 1.001  # solvers compare with the tolerance in their own rounding
_LIMIT_SLACK = 1e-6  # rad or m: some peers keep limits as float32


class Protocol(NamedTuple):
    """Targets, start and tolerances for a solver.

    Attributes:
        source: Where it comes from.
        reached: Maps errors, shape (n, 6), position [m] and rotation vector [rad], to whether they count as reached, shape (n,).
        reachable: Whether the targets are within reach; if not, they are all beyond it.
        from_middle: Whether the search starts from the middle of the range; if not, the solver chooses its start.
        tolerances: Distance [m] and angle [rad], for a solver that takes these two.
        component: The tolerance for a solver that compares each of six components with one number [m and rad].
        max_iterations: The largest number of steps; the solver's default if None.
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
        """The q that the search starts from [rad or m], shape (n_dof,), or None."""
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
    """Errors of poses T to targets, both (n, 4, 4): position [m] and rotation vector [rad] in the axes of T, shape (n, 6).

    In these axes TRAC-IK compares each component with its tolerance; for lengths the axes do not matter.
    """
    back = np.swapaxes(T[:, :3, :3], 1, 2)
    R = back @ targets[:, :3, :3]
    sine = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    size = np.linalg.norm(sine, axis=1, keepdims=True)
    angle = np.arctan2(size[:, 0], (np.trace(R, axis1=1, axis2=2) - 1) / 2)[:, None]
    axis = np.where(size > 0, sine, [1.0, 0.0, 0.0]) / np.where(
        size > 0, size, 1.0
    )  # any axis, if there is no rotation or half a turn
    way = (back @ (targets[:, :3, 3] - T[:, :3, 3])[:, :, None])[:, :, 0]
    return np.concatenate([way, axis * angle], axis=1)


def within_limits(robot: Robot, q: Array) -> NDArray[np.bool_]:
    """Which rows of q, shape (n, n_dof), are within all limits, shape (n,)."""
    return np.all((q >= robot.lower - _LIMIT_SLACK) & (q <= robot.upper + _LIMIT_SLACK), axis=1)
