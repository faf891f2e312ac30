"""Makes targets: poses of random configurations, poses of a smooth path, and poses beyond reach."""

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import COLUMN, KIND, OFFSET, PRISMATIC, RATIO
from ulna.kinematics import sample
from ulna.robot import Robot

Array = NDArray[np.float64]
_WAVES = 5.0  # periods of the quickest joint along a path
_SWING = 0.25  # of a joint's range, to each side of its middle


def middle(robot: Robot) -> Array:
    """The middle of each joint's range [rad or m], shape (n_dof,)."""
    lower, upper = sample.usual_range(robot.lower, robot.upper)
    return (lower + upper) / 2


def random_positions(robot: Robot, n: int, seed: int) -> Array:
    """Configurations drawn uniformly from the usual range [rad or m], shape (n, n_dof); their poses are reachable targets."""
    return sample.random_positions(robot.tree, n, seed)


def path_positions(robot: Robot, n: int, seed: int) -> Array:
    """A smooth path about the middle of the range [rad or m], shape (n, n_dof): sines of random period and phase."""
    lower, upper = sample.usual_range(robot.lower, robot.upper)
    rng = np.random.default_rng(seed)
    waves, phases = rng.uniform(1.0, _WAVES, robot.n_dof), rng.uniform(0.0, 2 * np.pi, robot.n_dof)
    time = np.linspace(0.0, 1.0, n)[:, None]
    return middle(robot) + _SWING * (upper - lower) * np.sin(2 * np.pi * waves * time + phases)


def longest_reach(robot: Robot) -> float:
    """An upper bound on the distance of the tip from the base [m]: the sum of the lengths of the chain."""
    chain = robot.tree.chain(str(robot.tip))
    slides = chain[chain[:, KIND] == PRISMATIC]
    ends = robot.tree.limits[:, slides[:, COLUMN].astype(int)] * slides[:, RATIO] + slides[:, OFFSET]
    return float(np.linalg.norm(chain[:, (3, 7, 11)], axis=1).sum() + np.abs(ends).max(axis=0).sum())


def out_of_reach(robot: Robot, n: int, seed: int) -> Array:
    """Poses whose position lies 1 % to 50 % beyond the longest reach, in all directions, shape (n, 4, 4)."""
    T = robot.forward_kinematics(random_positions(robot, n, seed))
    rng = np.random.default_rng(seed + 1)
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    T[:, :3, 3] = directions * longest_reach(robot) * rng.uniform(1.01, 1.5, (n, 1))
    return T
