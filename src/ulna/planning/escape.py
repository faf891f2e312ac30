"""Finds a free configuration next to a start that touches something a little."""

import numpy as np
from numpy.typing import NDArray

from ulna.planning.goals import Request
from ulna.planning.space import along

Array = NDArray[np.float64]
DEEPEST = 0.01  # [m]: a start that is deeper in something is not left
_STEPS = 30
_BEYOND = 1e-3  # [m]: how far out each step aims
_LARGEST_STEP = 0.05  # rad or m
_APART = 1e-3  # [rad or m]: of the samples of the way out


def escape_from(request: Request, fixed: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """A free configuration near the start, and how deep the start is [m]; None if it is too deep, or none is found.

    Steps along the gradient of the signed distance, of the entries of q that are not ``fixed``, each out of the deepest pair. On
    the straight way there, at samples, nothing touches but what touches at the start.
    """
    depth, tree = max(_missing(request, request.start)), request.tree
    if not depth <= DEEPEST:
        return None
    q = request.start.copy()
    for _ in range(_STEPS):
        gradient = np.where(fixed, 0.0, _way_out(request, q))
        square = float(gradient @ gradient)
        if square == 0.0:
            return None
        step = gradient * ((max(_missing(request, q)) + _BEYOND) / square)
        q = np.clip(q + step * min(1.0, _LARGEST_STEP / np.abs(step).max()), tree.lower, tree.upper)
        if request.is_free(q[None])[0]:
            return (q, max(depth, 0.0)) if _touches_nothing_else(request, q) else None
    return None


def _missing(request: Request, q: Array) -> tuple[float, float]:
    """How much the robot is too near to itself, and to the world, of which it is to keep the margin [m]."""
    checker, world = request.checker, request.world
    itself = -float(checker.signed_distance(q, None, self_collision=True))
    if world is None or not world.names:
        return itself, -np.inf
    return itself, request.margin - float(checker.signed_distance(q, world, self_collision=False))


def _way_out(request: Request, q: Array) -> Array:
    """The gradient in q of the distance of the pair that is too near by most."""
    itself, world = _missing(request, q)
    if world > itself:
        return request.checker.distance_gradient(q, request.world, self_collision=False)
    return request.checker.distance_gradient(q, None, self_collision=True)


def _touches_nothing_else(request: Request, q: Array) -> bool:
    """Whether all that touches on the way from the start to q touches at the start too, looked at every ``_APART``."""
    touching = {(pair.name_a, pair.name_b) for pair in request.touching(request.start)}
    way = along(request.start, q, _APART)
    near = (request.touching(there) for there in way[~request.is_free(way)])
    return all((pair.name_a, pair.name_b) in touching for pairs in near for pair in pairs)
