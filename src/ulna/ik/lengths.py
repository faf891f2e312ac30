"""Measures how large a robot is, for what a search compares with its size."""

import numpy as np

from ulna.kernels.layout import COLUMN, KIND, LARGEST, PRISMATIC, RATIO
from ulna.kinematics.tree import Tree

_TIMES = 2.0  # times the length of an arm is the greatest distance of two points that it reaches
_LEAST = 1e-6  # m
_USUAL = 32.0  # m, and 1 / 32 m: an arm between them is measured in metres


def arm_length(tree: Tree, link: str) -> float:
    """The lengths of all parts of the chain to a link together [m], slides at 0."""
    return float(np.linalg.norm(tree.chain(link)[:, [3, 7, 11]], axis=1).sum())


def unit_of_length(length: float) -> float:
    """The unit in which an arm of a length is searched [m]: a power of two, so that nothing is rounded on the way and back."""
    return 1.0 if length == 0.0 or 1 / _USUAL <= length <= _USUAL else float(2.0 ** np.rint(np.log2(length)))


def far_square(tree: Tree, link: str) -> float:
    """For the setting FAR: the square of the distance [m^2] that only slides can bridge; 0 where none is as long as that."""
    far = max(_TIMES * arm_length(tree, link), _LEAST)
    slides = [row for row in tree.chain(link) if int(row[KIND]) == PRISMATIC]
    lower, upper = np.clip(tree.lower, -LARGEST, LARGEST), np.clip(tree.upper, -LARGEST, LARGEST)
    ways = [abs(row[RATIO]) * (upper[int(row[COLUMN])] - lower[int(row[COLUMN])]) for row in slides]
    return far * far if any(way > far for way in ways) else 0.0
