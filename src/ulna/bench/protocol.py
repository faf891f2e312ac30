"""The protocols of inverse kinematics: which targets, from where the search starts, and what counts as reached.

Written once: ``ulna bench ik`` runs them on Ulna, ``make bench`` on the peers too. A solver's own word is not taken: its q must
be within the limits and reach the target by a forward kinematics that is not the solver's.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.bench.targets import middle, out_of_reach, random_positions
from ulna.robot import Robot

Array = NDArray[np.float64]
_SLACK = 1.001  # solvers stop at the tolerance by their own rounding
_LIMIT_SLACK = 1e-6  # rad or m: some peers keep limits as float32


class Protocol(NamedTuple):
    """What is asked of a solver.

    Attributes:
        source: Whose protocol it is.
        reached: Of errors (n, 6), position and rotation vector, which count as reached.
        reachable: Whether the targets are within reach; otherwise they are beyond it for certain.
        from_middle: Whether the search is given the middle of the range to start from; otherwise it starts where it likes.
        tolerances: The largest distance [m] and angle [rad] to ask a solver for that takes two.
        component: The tolerance to ask a solver for that compares each of six components with it [m and rad].
        max_iterations: The steps that a solver has; its own default where None.
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
        """Where the search is told to start, or None."""
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
    """What is left to the targets, shape (n, 6): the position [m] and the rotation vector [rad], in the axes of T.

    In these axes TRAC-IK compares each component with its tolerance; for lengths the axes do not matter.
    """
    back = np.swapaxes(T[:, :3, :3], 1, 2)
    R = back @ targets[:, :3, :3]
    sine = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    size = np.linalg.norm(sine, axis=1, keepdims=True)
    angle = np.arctan2(size[:, 0], (np.trace(R, axis1=1, axis2=2) - 1) / 2)[:, None]
    axis = np.where(size > 0, sine, [1.0, 0.0, 0.0]) / np.where(size > 0, size, 1.0)  # any will do for none, and for a half turn
    way = (back @ (targets[:, :3, 3] - T[:, :3, 3])[:, :, None])[:, :, 0]
    return np.concatenate([way, axis * angle], axis=1)


def within_limits(robot: Robot, q: Array) -> NDArray[np.bool_]:
    """Which rows of q keep all limits."""
    return np.all((q >= robot.lower - _LIMIT_SLACK) & (q <= robot.upper + _LIMIT_SLACK), axis=1)
