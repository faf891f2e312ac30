"""Finds a free configuration next to a start that touches something a little."""

import numpy as np
from numpy.typing import NDArray

from ulna.planning.goals import Question

Array = NDArray[np.float64]
DEEPEST = 0.01  # [m]: a start that is deeper in something is not left
_STEPS = 30
_BEYOND = 1e-3  # [m]: how far out each step aims
_LARGEST_STEP = 0.05  # rad or m
_APART = 1e-3  # [rad or m]: of the samples of the way out


def escape_from(question: Question, fixed: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """A free configuration near the start, and how deep the start is [m]; None if it is too deep, or none is found.

    Steps along the gradient of the signed distance, of the entries of q that are not ``fixed``, each out of the deepest pair. On
    the straight way there, at samples, nothing touches but what touches at the start.
    """
    depth, tree = max(_missing(question, question.start)), question.tree
    if not depth <= DEEPEST:
        return None
    q = question.start.copy()
    for _ in range(_STEPS):
        gradient = np.where(fixed, 0.0, _way_out(question, q))
        square = float(gradient @ gradient)
        if square == 0.0:
            return None
        step = gradient * ((max(_missing(question, q)) + _BEYOND) / square)
        q = np.clip(q + step * min(1.0, _LARGEST_STEP / np.abs(step).max()), tree.lower, tree.upper)
        if question.is_free(q[None])[0]:
            return (q, max(depth, 0.0)) if _touches_nothing_else(question, q) else None
    return None


def _missing(question: Question, q: Array) -> tuple[float, float]:
    """How much the robot is too near to itself, and to the world, of which it is to keep the margin [m]."""
    checker, world = question.checker, question.world
    itself = -float(checker.signed_distance(q, None, self_collision=True))
    if world is None or not world.names:
        return itself, -np.inf
    return itself, question.margin - float(checker.signed_distance(q, world, self_collision=False))


def _way_out(question: Question, q: Array) -> Array:
    """The gradient in q of the distance of the pair that is too near by most."""
    itself, world = _missing(question, q)
    if world > itself:
        return question.checker.distance_gradient(q, question.world, self_collision=False)
    return question.checker.distance_gradient(q, None, self_collision=True)


def _touches_nothing_else(question: Question, q: Array) -> bool:
    """Whether all that touches on the way from the start to q touches at the start too, looked at every ``_APART``."""
    start = question.start
    touching = {(pair.name_a, pair.name_b) for pair in question.collision(start).data.pairs}
    n = max(2, 1 + int(np.ceil(np.abs(q - start).max() / _APART)))
    ways = start + np.linspace(0.0, 1.0, n)[1:, None] * (q - start)
    near = (question.collision(way).data.pairs for way in ways[~question.is_free(ways)])
    return all((pair.name_a, pair.name_b) in touching for pairs in near for pair in pairs)
