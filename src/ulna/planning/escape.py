"""Finds a free configuration next to a start that touches something a little. Used by ``planner``."""

import numpy as np
from numpy.typing import NDArray

from ulna.planning.goals import Question

Array = NDArray[np.float64]
DEEPEST = 0.01  # [m]: a start that is deeper in something is not left
_STEPS = 30
_BEYOND = 1e-3  # [m]: how far out each step aims
_LARGEST_STEP = 0.05  # rad or m


def escape_from(question: Question, fixed: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """A free configuration near the start, and how deep the start is [m]; None if it is too deep, or none is found.

    Steps along the gradient of the signed distance, of the entries of q that are not ``fixed``, each out of the deepest pair.
    """
    checker, world, tree = question.checker, question.world, question.tree
    depth = question.margin - float(checker.signed_distance(question.start, world, self_collision=True))
    if not depth <= DEEPEST:
        return None
    q = question.start.copy()
    for _ in range(_STEPS):
        gradient = np.where(fixed, 0.0, checker.distance_gradient(q, world, self_collision=True))
        square = float(gradient @ gradient)
        if square == 0.0:
            return None
        missing = question.margin - float(checker.signed_distance(q, world, self_collision=True)) + _BEYOND
        step = gradient * (missing / square)
        q = np.clip(q + step * min(1.0, _LARGEST_STEP / np.abs(step).max()), tree.lower, tree.upper)
        if question.is_free(q[None])[0]:
            return q, max(depth, 0.0)
    return None
