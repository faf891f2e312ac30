"""Draws random joint positions within the limits."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_count
from ulna.errors import InputError
from ulna.kernels.layout import COLUMN, KIND, LARGEST, PARENT, PRISMATIC
from ulna.kinematics.tree import Tree

_NO_LIMIT = 1e3  # descriptions write 1e16 for no limit; positions drawn from such a range would be useless


def usual_range(lower: ArrayLike, upper: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The limits. A missing one is one turn from the other; two missing ones are -pi and pi."""
    sides = (np.asarray(side, dtype=np.float64) for side in (lower, upper))
    lower, upper = (np.where(np.abs(side) > _NO_LIMIT, np.copysign(np.inf, side), side) for side in sides)
    low = np.where(np.isinf(lower), np.where(np.isinf(upper), -np.pi, np.subtract(upper, 2 * np.pi)), lower)
    return low, np.where(np.isinf(upper), low + 2 * np.pi, upper)


def random_positions(tree: Tree, n: int, seed: int = 0) -> NDArray[np.float64]:
    """Joint positions within ``usual_range`` [rad or m], shape (n, n_dof), reproducible for a robot and a seed."""
    return np.random.default_rng(seed).uniform(*usual_range(tree.lower, tree.upper), (n, tree.n_dof))


def uniform_positions(tree: Tree, n: int | None, seed: object) -> NDArray[np.float64]:
    """Joint positions, uniform within ``random_range`` [rad or m], shape (n, n_dof), or (n_dof,) for None."""
    shape = (tree.n_dof,) if n is None else (as_count("n", n), tree.n_dof)
    try:
        rng = np.random.default_rng(seed)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise InputError("seed", f"{seed!r} is not a seed ({error})") from None
    return rng.uniform(*random_range(tree), shape)


def random_range(tree: Tree) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The ranges for random positions, shape (n_dof,) each: the limits, and defaults for missing limits.

    An angle without limits gets +-pi. A prismatic joint without limits gets the robot's length to both sides. With one limit, the
    range is as wide from there. An angle limit beyond 1e3 rad, or a position beyond 1e6 m, counts as missing.
    """
    slides = np.zeros(tree.n_dof, dtype=bool)
    slides[tree.joints[tree.joints[:, KIND] == PRISMATIC, COLUMN].astype(np.int64)] = True
    missing_limit, half_range = np.where(slides, LARGEST, _NO_LIMIT), np.where(slides, length_of_robot(tree), np.pi)
    no_lower, no_upper = tree.lower < -missing_limit, tree.upper > missing_limit
    low = np.where(no_lower, np.where(no_upper, -half_range, tree.upper - 2 * half_range), tree.lower)
    return low, np.where(no_upper, low + 2 * half_range, tree.upper)


def length_of_robot(tree: Tree) -> float:
    """The length of the longest chain, with prismatic joints at 0 [m]; 1 for a robot of length 0."""
    distances = np.zeros(len(tree.joints))
    for k, row in enumerate(tree.joints):
        parent = int(row[PARENT])
        distances[k] = np.linalg.norm(row[3:12:4]) + (distances[parent] if parent >= 0 else 0.0)
    tips = [
        np.linalg.norm(T[:3, 3]) + (distances[tree.link_row[link]] if tree.link_row[link] >= 0 else 0.0)
        for link, T in tree.link_offset.items()
    ]
    return float(max(tips)) or 1.0
