"""What is left of a path after it was shortened is certified edge by edge, also where an edge was known to be free before."""

import numpy as np
import pytest


@pytest.fixture(scope="module")
def motion(panda, world):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0
    return panda.plan(left, right, world)._searched.motion


@pytest.mark.parametrize("certify", [True, False])
def test_every_edge_of_a_shortened_path_is_free_as_it_is(panda, world, certify):
    left, right = panda.home.copy(), panda.home.copy()
    left[0], right[0] = 1.0, -1.0
    certified = [certified_again(panda.plan(left, right, world, seed=seed, certify=certify)) for seed in range(20)]
    assert all(certified) == certify, "and of those at samples some are not, so that it can fail"


def certified_again(plan):
    """Whether each edge of a plan is certified when it is looked at alone, from one end or the other."""
    is_free, nothing = plan._searched.motion.is_free, np.zeros((1, plan.path.shape[1]))
    edges = np.stack([plan.path[:-1], plan.path[1:]], axis=1)
    return all(is_free(edge, nothing) or is_free(edge[::-1], nothing) for edge in edges)


def test_an_edge_of_the_given_path_that_is_not_free_is_not_taken_for_one_that_is_known_to_be(panda, motion):
    """Paths with edges through the post: shortening passes some by, and around these it moves what it knows of the others.

    An edge that is wrongly known to be free is not looked at again, so a path that touches would be returned as confirmed.
    """
    edges = motion.edges(certify=True)
    rng, outcomes = np.random.default_rng(4), []
    for _ in range(300):
        path = np.cumsum(rng.normal(scale=0.25, size=(12, 7)), axis=0) + panda.home
        path[:, 0] += rng.uniform(-1, 1)
        found = edges.checked(np.clip(path, panda.lower, panda.upper), shorten=True)
        outcomes.append(found is not None)
        assert found is None or edges.checked(found) is not None
    assert 30 < sum(outcomes) < 270, "both happen often"
