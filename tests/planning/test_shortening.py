"""What is left of a path after it was shortened is certified edge by edge, also where an edge was known to be free before."""

import numpy as np
import pytest

import ulna


@pytest.mark.parametrize("certify", [True, False])
def test_every_edge_of_a_shortened_path_is_free_as_it_is(panda, certify):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    world.add("shelf", ulna.Box((0.5, 2, 0.05)), ulna.pose((0.6, 0, 0.95)))
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0
    certified = [certified_again(panda.plan(left, right, world, seed=seed, certify=certify)) for seed in range(20)]
    assert all(certified) == certify, "and of those at samples some are not, so that it can fail"


def certified_again(plan):
    """Whether each edge of a plan is certified when it is looked at alone, from one end or the other."""
    is_free, nothing = plan._searched.motion.is_free, np.zeros((1, plan.path.shape[1]))
    edges = np.stack([plan.path[:-1], plan.path[1:]], axis=1)
    return all(is_free(edge, nothing) or is_free(edge[::-1], nothing) for edge in edges)
