"""Checks whether an edge is free and satisfies the constraints, and records refused edges."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.entries.continuous import BREADTH, edge_is_free, edge_is_free_at_samples
from ulna.engine.decorators import kernel, routine, workspace
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.scene import Edge, EdgeCheck
from ulna.kernels.planning.space import distance
from ulna.planning.entries.keeping import Keeping, satisfies_all
from ulna.planning.entries.search_records import MAX_REFUSED, SearchSettings


class EdgeContext(NamedTuple):
    """The arguments of ``is_free`` besides the edge: the scene with its workspaces, the settings, the space.

    Entries build it, since no function can return a record in Numba.
    """

    check: EdgeCheck
    settings: SearchSettings
    space: NDArray
    no_spread: NDArray
    keeping: Keeping | None
    """The constraints; None without any, so that their code is not compiled."""


@workspace
def drop_periods(space):
    """A copy of the space without periods, in which joints without limits do not take the shorter turn."""
    space = space.copy()
    for k in range(space.shape[0]):
        space[k].period = 0.0
    return space


@routine
def is_free(context, q_a, q_b, spread):
    """Whether an edge from q_a to q_b is free and satisfies the constraints, including all within ``spread`` of it.

    Depending on the settings, collisions are certified or checked at samples. The constraints are always certified, and checked
    first, since this takes less time.
    """
    if not satisfies_all(context.check.scene.joints, context.keeping, context.check.work, q_a, q_b, spread):
        return False
    return is_clear(context, q_a, q_b, spread, context.settings.resolution)


@routine
def is_clear(context, q_a, q_b, spread, resolution):
    """Whether an edge from q_a to q_b is free of contacts within ``spread``, by certificate or at samples.

    resolution: the resolution of the certificate [m]; infinite for a single test without subdivision.
    """
    check, edge, margin, sampled = context.check, Edge(q_a, q_b, spread), context.settings.margin, context.settings.sample_spacing
    if sampled > 0.0:
        n_blocks = max(1, int(np.ceil(distance(q_a, q_b, context.space) / (sampled * WIDTH))))
        return edge_is_free_at_samples(check, edge, n_blocks, margin)
    return edge_is_free(check, edge, resolution, margin, None, BREADTH)


@kernel
def check_edge(context, q_a, q_b, refused, state):
    """Check and count an edge of a search: whether it is free. A refused edge is recorded in ``refused``."""
    state.checks += 1
    if is_free(context, q_a, q_b, context.no_spread):
        return True
    record_refused(q_a, q_b, refused, state)
    return False


@routine
def record_refused(q_a, q_b, refused, state):
    """Record a refused edge in place of the oldest one."""
    place = state.refused % MAX_REFUSED
    state.refused += 1
    for k in range(refused.shape[2]):
        refused[place, 0, k], refused[place, 1, k] = q_a[k], q_b[k]
