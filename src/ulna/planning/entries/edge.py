"""Decides whether an edge of a plan is free and keeps its constraints, and remembers the last ones that do not."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.entries.continuous import BREADTH, edge_is_free, edge_is_free_at_samples
from ulna.engine.decorators import kernel, routine, workspace
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.scene import Edge, EdgeCheck
from ulna.kernels.planning.space import distance
from ulna.planning.entries.keeping import Keeping, keeps_all
from ulna.planning.search_records import MAX_REFUSED, SearchSettings


class EdgeContext(NamedTuple):
    """All that ``is_free`` needs besides an edge: the scene with its workspaces, the settings, the space.

    An entry makes it, since Numba lets no function return a record.
    """

    check: EdgeCheck
    settings: SearchSettings
    space: NDArray
    no_spread: NDArray
    keeping: Keeping | None
    """None without constraints: what is for these alone is not compiled then."""


@workspace
def without_turns(space):
    """The space of edges from q_a straight to q_b, also where a joint that turns without end has a shorter way."""
    space = space.copy()
    for k in range(space.shape[0]):
        space[k].period = 0.0
    return space


@routine
def is_free(context, q_a, q_b, spread):
    """Whether all within ``spread`` of the edge from q_a to q_b is free: certainly, or at samples, as the settings say.

    And whether it keeps the constraints, for certain in any case: that is known first, since it takes less time.
    """
    if not keeps_all(context.check.scene.joints, context.keeping, context.check.work, q_a, q_b, spread):
        return False
    return is_clear(context, q_a, q_b, spread, context.settings.resolution)


@routine
def is_clear(context, q_a, q_b, spread, resolution):
    """Whether nothing touches within ``spread`` of the edge from q_a to q_b: certainly, or at samples, as the settings say.

    resolution: of the certificate [m]; infinite for one look at the edge.
    """
    check, edge, margin, sampled = context.check, Edge(q_a, q_b, spread), context.settings.margin, context.settings.sample_spacing
    if sampled > 0.0:
        n_blocks = max(1, int(np.ceil(distance(q_a, q_b, context.space) / (sampled * WIDTH))))
        return edge_is_free_at_samples(check, edge, n_blocks, margin)
    return edge_is_free(check, edge, resolution, margin, None, BREADTH)


@kernel
def passes(context, q_a, q_b, refused, state):
    """Count an edge of a search; whether it is free. One that is not is kept in ``refused``, in the place of the oldest."""
    state.checks += 1
    if is_free(context, q_a, q_b, context.no_spread):
        return True
    keep(q_a, q_b, refused, state)
    return False


@routine
def keep(q_a, q_b, refused, state):
    """Keep an edge that is not free."""
    place = state.refused % MAX_REFUSED
    state.refused += 1
    for k in range(refused.shape[2]):
        refused[place, 0, k], refused[place, 1, k] = q_a[k], q_b[k]
