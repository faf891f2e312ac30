"""Decides whether an edge of a plan is free, as its settings say."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.drivers.carried import carried_by
from ulna.drivers.free_edge import edge_is_free, edge_is_free_at_samples, interval_work
from ulna.engine.decorators import routine, workspace
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.ball_motion import world_rounding
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import distance


class Edges(NamedTuple):
    """What it takes to decide whether an edge is free."""

    scene: Scene
    carried: NamedTuple
    work: tuple
    settings: NDArray
    space: NDArray
    of_world: float
    no_spread: NDArray


@workspace
def edges_of(scene, settings, space):
    """The workspaces of a scene."""
    carried, work = carried_by(scene), interval_work(space.shape[1])
    return Edges(scene, carried, work, settings, space, world_rounding(scene), np.zeros(space.shape[1]))


@workspace
def straight_edges_of(edges):
    """The same for a path, whose differences are taken as they are."""
    space = edges.space.copy()
    for k in range(space.shape[1]):
        space[layout.PERIOD, k] = 0.0
    return Edges(edges.scene, edges.carried, edges.work, edges.settings, space, edges.of_world, edges.no_spread)


@routine
def is_free(edges, q_a, q_b, spread):
    """Whether all within ``spread`` of the edge from q_a to q_b is free: certainly, or at samples, as the settings say."""
    settings, sampled = edges.settings, edges.settings[layout.SAMPLED]
    margin = settings[layout.MARGIN]
    if sampled > 0.0:
        n_blocks = int(np.ceil(distance(q_a, q_b, edges.space) / (sampled * WIDTH)))
        return edge_is_free_at_samples(
            edges.scene, edges.carried, edges.work, q_a, q_b, spread, max(1, n_blocks), margin, edges.of_world
        )
    return edge_is_free(
        edges.scene, edges.carried, edges.work, q_a, q_b, spread, settings[layout.RESOLUTION], margin, edges.of_world
    )
