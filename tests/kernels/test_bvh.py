"""The BVH finds what a test of each object finds, whatever their number."""

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from kernel_modes import compiled
from ulna.collision.arena import Arena
from ulna.collision.object_tables import make_objects
from ulna.collision.object_tree import bounds, compact_order, max_nodes, remove_child, write_tree
from ulna.collision.objects import numbers_below
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.kernels.collision.bvh import FOUND, STACK, rows_within
from ulna.kernels.layout import CONTACT


class Tree(NamedTuple):
    """What a search takes of a scene; without points, all nodes hold AABBs."""

    nodes: NDArray
    points: NDArray | None


def search(nodes, root, low, high, stack, some, found):
    """In slices, as many as it takes: those that are found, one after the other."""
    stack[0], top, count = root, 1, 0
    while top > 0:
        n, top = rows_within(Tree(nodes, None), ((low[0], low[1], low[2]), (high[0], high[1], high[2])), stack, top, some)
        for i in range(n):
            found[count] = some[i]
            count += 1
    return count


def tree_of(low, high):
    n = len(low)
    arena = Arena(0, 0, 2 * max_nodes(n))
    return arena, write_tree(arena, low, high, -1.0 - np.arange(n))


def found_by(arena, tree, at_low, at_high, n):
    found = np.empty(n, dtype=np.int64)
    stack, some = np.empty(STACK, dtype=np.int64), np.empty(FOUND, dtype=np.int64)
    count = compiled(search)(arena.nodes, tree.root, at_low, at_high, stack, some, found)
    return sorted(found[:count].tolist())


def found_in(low, high, at_low, at_high):
    return found_by(*tree_of(low, high), at_low, at_high, len(low))


@pytest.mark.parametrize("n", [1, 7, 8, 9, 63, 64, 65, 512, 513, 700])
def test_the_bvh_finds_exactly_the_objects_whose_bounds_overlap_those_given(rng, n):
    low = rng.uniform(-1, 1, (n, 3))
    high = low + rng.uniform(0, 0.3, (n, 3))
    for _ in range(20):
        at_low = rng.uniform(-1.2, 1.2, 3)
        at_high = at_low + rng.uniform(0, 0.6, 3)
        expected = np.flatnonzero(((low <= at_high) & (high >= at_low)).all(axis=1))
        assert found_in(low, high, at_low, at_high) == expected.tolist()
    assert found_in(low, high, np.full(3, -9.0), np.full(3, 9.0)) == list(range(n))


def test_bounds_that_touch_overlap_and_a_hair_apart_they_do_not():
    low, high = np.zeros((1, 3)), np.ones((1, 3))
    for axis in np.eye(3):
        assert found_in(low, high, axis, axis + 1) == [0]
        assert found_in(low, high, axis * (1 + 1e-12), axis + 1) == []
        assert found_in(low, high, -axis - 1, 1 - axis) == [0]


def test_objects_of_no_extent_in_one_place_are_all_found():
    low = np.full((30, 3), 0.25)
    assert found_in(low, low, low[0], low[0]) == list(range(30))


@pytest.mark.parametrize("n", [1, 8, 9, 64, 65, 513])
def test_a_tree_without_one_has_all_others_and_the_tree_before_is_as_it_was(rng, n):
    low = rng.uniform(-1, 1, (n, 3))
    (arena, before), everywhere = tree_of(low, low), (np.full(3, -9.0), np.full(3, 9.0))
    for place in (0, n // 2, n - 1):
        tree = remove_child(arena, before, place)
        assert found_by(arena, tree, *everywhere, n) == [k for k in range(n) if k != place]
        assert sorted(numbers_below(arena.nodes, tree.root).tolist()) == [k for k in range(n) if k != place]
    assert found_by(arena, before, *everywhere, n) == list(range(n))


def test_the_bounds_of_a_turned_box_hold_its_corners_and_touch_them(rng):
    for _ in range(20):
        extents, T = rng.uniform(0.1, 1, 3), pose(rng.normal(size=3), rng.uniform(-3, 3, 3))
        world = make_objects({"box": Box(extents)}, {"box": T}, {})
        corners = (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5) * extents @ T[:3, :3].T + T[:3, 3]
        low, high = bounds(world.solids)
        margin = CONTACT * extents.sum() / 2  # for what touches the box
        np.testing.assert_allclose(low[0] + margin, corners.min(axis=0), rtol=0, atol=1e-14)
        np.testing.assert_allclose(high[0] - margin, corners.max(axis=0), rtol=0, atol=1e-14)


def test_the_order_holds_everything_once_and_its_eights_are_compact(rng):
    for n in (1, 8, 9, 100, 4096):
        centers = rng.uniform(0, 1, (n, 3))
        order = compact_order(centers)
        assert sorted(order.tolist()) == list(range(n))
    eights = centers[order].reshape(-1, 8, 3)
    spread = (eights.max(axis=1) - eights.min(axis=1)).max(axis=1)
    assert np.median(spread) < 0.2  # a cube that holds eight of 4096 has a side of 0.125
