"""The order of objects in their tree: all of them, and near ones together."""

import numpy as np
import pytest

from ulna.collision.object_tree import compact_order, median_split_order


def areas(centers, half, order):
    """The surface areas of the boxes about eight objects that follow one another, added up: the cost of a search of them."""
    low, high = (centers - half)[order], (centers + half)[order]
    groups = [slice(k, k + 8) for k in range(0, len(order), 8)]
    sides = np.array([high[part].max(axis=0) - low[part].min(axis=0) for part in groups])
    return (sides * np.roll(sides, 1, axis=1)).sum()


@pytest.mark.parametrize("order", [median_split_order, compact_order])
@pytest.mark.parametrize("n", [1, 7, 8, 9, 64, 65, 100, 1000])
def test_an_order_has_every_object_once(order, n, rng):
    assert sorted(order(rng.uniform(-1, 1, (n, 3))).tolist()) == list(range(n))
    assert sorted(order(np.zeros((n, 3))).tolist()) == list(range(n))


@pytest.mark.parametrize("n", [50, 100, 500, 2000])
def test_halves_make_smaller_boxes_than_a_curve_through_all(n, rng):
    shares = []
    for _ in range(5):
        centers, half = rng.uniform(-1, 1, (n, 3)), rng.uniform(0.01, 0.1, (n, 3))
        shares.append(areas(centers, half, median_split_order(centers)) / areas(centers, half, compact_order(centers)))
    assert np.mean(shares) < 0.95
