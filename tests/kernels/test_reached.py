"""The nodes that a body can reach in eight intervals: what a test of each object finds, and few others."""

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import formulas
from kernel_modes import compiled
from ulna.collision.arena import Arena
from ulna.collision.object_tree import compact_order, max_nodes, write_tree
from ulna.engine.lanes import WIDTH, empty_rows, load, store
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.reached import NEVER, ball_bounds, push_reached, tree_is_reached
from ulna.kernels.collision.scene import Posed
from ulna.kernels.layout import BODY_WIDTH, BOX, CAPSULE, HALF_EXTENTS, RADIUS, REACH, SHAPE, SPHERE
from ulna.kernels.spatial.se3 import load_pose

HALF = np.array([0.05, 0.2, 0.1])


class Tree(NamedTuple):
    """What a search takes of a scene; without points, all nodes hold AABBs."""

    nodes: NDArray
    points: NDArray | None


def search(nodes, root, bodies, poses, within_rows, stack, found):
    """The objects at which a search ends, as the certificate of an edge does it; and whether the ball alone reaches any."""
    a, within, count, top = load_pose(poses, 0), load(within_rows, 0), 0, 1
    p = a[3], a[7], a[11]
    body = Posed(bodies, None, 0, a), p, ball_bounds(p, within + bodies[0, REACH])
    stack[0] = root
    while top > 0:
        top -= 1
        if stack[top] >= 0:
            top = push_reached(Tree(nodes, None), stack[top], body, within, None, stack, top)
        else:
            found[count] = -1 - stack[top]
            count += 1
    return count, tree_is_reached(Tree(nodes, None), root, p, within, bodies[0, REACH], stack)


def tree_of(points):
    arena = Arena(0, 0, max_nodes(len(points)))
    return arena.nodes, write_tree(arena, points, points, -1.0 - np.arange(len(points))).root


def body(kind):
    row, half = np.zeros((1, BODY_WIDTH)), {SPHERE: 0 * HALF, CAPSULE: HALF * (0, 0, 1), BOX: HALF}[kind]
    row[0, SHAPE], row[0, HALF_EXTENTS : HALF_EXTENTS + 3], row[0, RADIUS] = kind, half, 0.0 if kind == BOX else 0.03
    row[0, REACH] = np.linalg.norm(half) + row[0, RADIUS]
    return row


def gap(row, T, point):
    """The distance of a point from a body: of its place in the body's frame from the box of the core, less the radius."""
    x = T[:3, :3].T @ (point - T[:3, 3])
    half = row[0, HALF_EXTENTS : HALF_EXTENTS + 3]
    return np.linalg.norm(x - np.clip(x, -half, half)) - row[0, RADIUS]


@pytest.mark.slow
@pytest.mark.parametrize("kind", [SPHERE, CAPSULE, BOX])
@pytest.mark.parametrize("n", [1, 9, 500])
def test_every_point_within_reach_in_any_lane_is_found_and_few_others(rng, kind, n):
    points = rng.uniform(-1, 1, (n, 3))
    points = points[compact_order(points)]
    (nodes, root), row = tree_of(points), body(kind)
    stack, found, seen, surplus = np.empty(STACK, dtype=np.int64), np.empty(n, dtype=np.int64), 0, 0
    for _ in range(20):
        poses, within_rows = empty_rows(12), empty_rows(1)
        turns = [formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3)) for _ in range(WIDTH)]
        Ts = [formulas.transform(R, rng.uniform(-1, 1, 3)) for R in turns]
        within = np.where(rng.random(WIDTH) < 0.3, NEVER, rng.uniform(0, 0.2, WIDTH))
        for i in range(12):
            store(poses, i, np.array([T[:3].ravel()[i] for T in Ts]))
        store(within_rows, 0, within)
        near = {k for k, p in enumerate(points) if any(w >= 0 and gap(row, T, p) <= w for T, w in zip(Ts, within, strict=True))}
        count, reached = compiled(search)(nodes, root, row, poses, within_rows, stack, found)
        assert len(set(found[:count].tolist())) == count
        assert near <= set(found[:count].tolist())
        assert reached or not near
        seen, surplus = seen + len(near), surplus + count - len(near)
    assert surplus <= 0.2 * seen + 20, "a point is a box without extents: the bound is nearly the distance"


def test_a_lane_in_which_nothing_is_looked_for_reaches_nothing(rng):
    points = rng.uniform(-0.1, 0.1, (100, 3))
    (nodes, root), poses, within_rows = tree_of(points), empty_rows(12), empty_rows(1)
    for i, x in enumerate(np.eye(4)[:3].ravel()):
        store(poses, i, np.full(WIDTH, x))
    store(within_rows, 0, np.full(WIDTH, NEVER))
    stack, found = np.empty(STACK, dtype=np.int64), np.empty(100, dtype=np.int64)
    assert compiled(search)(nodes, root, body(BOX), poses, within_rows, stack, found) == (0, False)
