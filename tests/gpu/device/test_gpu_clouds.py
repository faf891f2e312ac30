"""Worlds of many solids on a GPU, such as clouds of points, against the robot on the CPU.

See ``test_gpu_robot.py``. In the simulator few solids already make a BVH.
"""

import os

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import ulna
from ulna.collision import object_tables
from ulna.collision.arena import Arena
from ulna.collision.entries.morton_order import NUMBER, NUMBER_BITS
from ulna.collision.object_tree import max_cloud_nodes, write_cloud
from ulna.collision.objects import numbers_below, table_of
from ulna.gpu import cloud_trees, scenes, search
from ulna.gpu.cloud_trees import CloudTrees, PlacedCloud, sorted_keys, write_tree
from ulna.kernels.collision.collision_layout import CHILD, NODE_ROWS, PLACES
from ulna.kernels.layout import BODY_WIDTH

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"
N = 3 if SIMULATED else 20_000
POINTS = 200 if SIMULATED else 100_000
RADIUS = 0.03 if SIMULATED else 0.004
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)
pytestmark = pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")  # of missing children, in kernels as plain Python


@pytest.fixture(autouse=True)
def _few_solids(monkeypatch):
    if SIMULATED:
        monkeypatch.setattr(scenes, "MAX_ONE_BY_ONE", 20)
        monkeypatch.setattr(search, "STEPS", 900)


@pytest.fixture
def q(panda):
    return np.random.default_rng(3).uniform(panda.lower, panda.upper, (N, panda.n_dof))


def wall(seed, n=POINTS):
    """Points of a bent wall, as a camera sees it."""
    rng = np.random.default_rng(seed)
    y, z = rng.uniform(-0.8, 0.8, n), rng.uniform(-0.1, 1.1, n)
    return np.column_stack([0.45 + 0.1 * np.sin(5.0 * y + seed), y, z])


def seen():
    world = ulna.World()
    world.add("wall", ulna.PointCloud(wall(1), RADIUS))
    return world


def furnished():
    """Two clouds, terrain, and single solids; some may be touched."""
    world = seen()
    crowd, T = ulna.PointCloud(wall(2, POINTS // 2).astype(np.float32), RADIUS), ulna.pose((-0.9, 0.1, 0.0), (0, 0, 2.0))
    world.add("crowd", crowd, T, touch_links=["panda_link7", "panda_hand"])
    world.add("ground", ulna.HeightMap(np.random.default_rng(5).uniform(-0.3, -0.2, (6, 6)), 0.3), touch_links=["panda_link0"])
    world.add("ball", ulna.Sphere(0.1), ulna.pose((0.3, 0.4, 0.7)), touch_links=["panda_hand"])
    world.add("box", ulna.Box((0.1, 0.2, 0.3)), ulna.pose((-0.3, 0.3, 0.5), (1, 0, 0)))
    return world


def terrain():
    """Boxes alone."""
    world = ulna.World()
    world.add("ground", ulna.HeightMap(np.random.default_rng(5).uniform(-0.5, 0.4, (8, 8)), 0.3))
    world.add("box", ulna.Box((0.1, 0.2, 0.3)), ulna.pose((-0.3, 0.3, 0.5), (1, 0, 0)))
    return world


def stones():
    """A cloud beside a hull, whose distances have no closed form."""
    world = seen()
    world.add("stone", ulna.ConvexMesh(np.random.default_rng(5).normal(scale=0.1, size=(12, 3))), ulna.pose((0.3, -0.4, 0.4)))
    return world


def check(robot, on_gpu, q, world):
    distances, expected = on_gpu.signed_distance(q, world), robot.signed_distance(q, world)
    np.testing.assert_allclose(distances, expected, rtol=0, atol=1e-9)
    far = np.abs(expected) > 1e-9
    assert (on_gpu.in_collision(q, world) == robot.in_collision(q, world))[far].all()


WORLDS = pytest.mark.parametrize("make", [seen, furnished, terrain, stones])


@WORLDS
def test_collisions_and_distances_are_those_of_the_cpu(panda, on_gpu, q, make):
    world = make()
    assert on_gpu._scenes.of(world, True, np.float64, 0).sizes[-1], "the scene has a BVH"
    check(panda, on_gpu, q, world)
    hits = panda.in_collision(q, world)
    assert hits.any()
    assert (on_gpu.in_collision(cuda.to_device(q), world).copy_to_host() == on_gpu.in_collision(q, world)).all()


@WORLDS
def test_edges_are_those_of_the_cpu(panda, on_gpu, make):
    world, rng = make(), np.random.default_rng(6)
    n = 3 if SIMULATED else 3000
    a = rng.uniform(panda.lower, panda.upper, (n, 7))
    a[0] = panda.home
    b = np.clip(a + rng.normal(scale=0.1, size=(n, 7)), panda.lower, panda.upper)
    found, expected = on_gpu.edge_in_collision(a, b, world), panda.edge_in_collision(a, b, world)
    differ = found.in_collision != expected.in_collision
    assert differ.mean() <= 1e-3, "by what is nearer than the resolution alone"
    assert np.abs(found.free_until - expected.free_until)[~differ].max() < 0.02


def test_solutions_are_clear_of_a_cloud(panda, on_gpu):
    world = seen()
    q = panda.random(40 * N, seed=8)
    T = panda.forward_kinematics(q[~panda.in_collision(q, world)][: 2 if SIMULATED else N])
    found = on_gpu.inverse_kinematics(T, world=world)
    assert found.success.all()
    assert not panda.in_collision(found.q, world).any()


def noted(calls, function, note):
    def call(*arguments):
        found = function(*arguments)
        calls.append(note(*arguments, found))
        return found

    return call


def test_a_change_of_a_world_is_seen_and_copies_and_builds_what_is_new_alone(panda, on_gpu, q, monkeypatch):
    world, copied, built = furnished(), [], []
    check(panda, on_gpu, q, world)
    of_arena = noted(copied, scenes.ArenaCopy._copied, lambda *given: (given[1], given[3] - given[-1][1]))
    monkeypatch.setattr(scenes.ArenaCopy, "_copied", of_arena)
    monkeypatch.setattr(cloud_trees, "write_tree", noted(built, write_tree, lambda placed, *_: len(placed.cloud.points)))
    for change, n_built in (
        (lambda: world.move("box", ulna.pose((-0.3, -0.3, 0.5))), []),
        (lambda: world.update("wall", wall(3, POINTS - 1)), [POINTS - 1]),
        (lambda: world.move("crowd", ulna.pose((0.1, 0.0, 0.1))), [POINTS // 2]),
        (lambda: world.remove("ground"), []),
        (lambda: world.add("post", ulna.Capsule(0.05, 0.5), ulna.pose((0.4, 0.0, 0.6))), []),
    ):
        change()
        copied.clear()
        built.clear()
        check(panda, on_gpu, q, world)
        assert built == n_built
        assert [name for name, _ in copied] == ["objects", "points", "nodes"], "the second call finds the scene on the device"
        assert max(n for _, n in copied) <= 7
    world.remove("crowd")
    world.remove("wall")
    world.add("ground", ulna.HeightMap(np.full((5, 5), 0.2), 0.3))
    check(panda, on_gpu, q, world)


def test_worlds_take_turns(panda, on_gpu, q):
    worlds = seen(), terrain()
    for world in (*worlds, None, *worlds):
        check(panda, on_gpu, q[:3], world)


def test_more_clouds_than_one_node_has_places_for_are_indexed_by_the_cpu(panda, q, monkeypatch):
    monkeypatch.setattr(scenes, "MAX_CLOUDS", 1)
    on_gpu, world = panda.on_gpu(), furnished()
    assert [len(placed.cloud.points) for placed in on_gpu._scenes.of(world, True, np.float64, 0).clouds] == [POINTS]
    check(panda, on_gpu, q, world)


def test_an_arena_that_is_full_is_copied_to_another(panda, q, monkeypatch):
    monkeypatch.setattr(object_tables, "_SPARE", 4)
    on_gpu, world, copies = panda.on_gpu(), furnished(), set()
    for k in range(4):
        world.move("ground", ulna.pose((0.0, 0.0, 0.01 * k)))
        check(panda, on_gpu, q[:1], world)
        copies.add(id(on_gpu._scenes._arena._copies["objects"][1]))
    assert len(copies) > 1


def points_of(n, dtype=np.float64):
    points = np.random.default_rng(n).uniform(-1.0, 1.0, (n, 3)).astype(dtype)
    points[n // 2 :, 0] = 0.25  # a plane
    return points


def test_keys_are_sorted_by_their_codes():
    points = points_of(300 if SIMULATED else 300_000, np.float32)
    keys = sorted_keys(cuda.to_device(points), 0).copy_to_host()
    assert (np.sort(keys & NUMBER) == np.arange(len(points))).all()
    codes = keys >> NUMBER_BITS
    assert (np.diff(codes) >= 0).all()
    of_same = np.diff(codes) == 0
    assert (np.diff(keys & NUMBER)[of_same] > 0).all(), "equal codes keep their order"
    one_place = sorted_keys(cuda.to_device(np.full((20, 3), 0.5)), 0).copy_to_host()
    assert (one_place == np.arange(20)).all()


@pytest.mark.parametrize("n", [1, 8, 9, 65, 200] + ([] if SIMULATED else [300_000, 1_000_000]))
def test_a_tree_has_every_point_and_is_that_of_the_cpu(n, monkeypatch):
    monkeypatch.setattr(cloud_trees, "_BITS", 6)  # as the CPU has them for few points; compiled code has its own
    cloud, T, first = (
        ulna.PointCloud(points_of(n, np.float32 if n % 2 else np.float64), 0.01),
        ulna.pose((0.1, 0.2, 0.3), (1, 2, 0.3)),
        3,
    )
    placed, there = (
        PlacedCloud(cloud, T, 0),
        cuda.device_array((NODE_ROWS * (first + CloudTrees.room((PlacedCloud(cloud, T, 0),))), 8)),
    )
    write_tree(placed, there, first, 0)
    nodes, root = there.copy_to_host(), first + cloud_trees._root(n)
    numbers = numbers_below(nodes, PLACES * root)
    solids = table_of(np.zeros((1, BODY_WIDTH)), nodes, numbers)[:, 3:12:4]
    expected = cloud.points @ T[:3, :3].T + T[:3, 3]
    assert np.allclose(solids[np.lexsort(solids.round(9).T)], expected[np.lexsort(expected.round(9).T)], atol=1e-6)
    rows = nodes[NODE_ROWS * root : NODE_ROWS * (root + 1)]
    assert np.allclose(rows[:3].min(axis=1), expected.min(axis=0) - placed.reach, atol=1e-6)
    assert np.allclose(rows[3:CHILD].max(axis=1), expected.max(axis=0) + placed.reach, atol=1e-6)
    if SIMULATED:
        arena = Arena(1, 0, max_cloud_nodes(n))
        tree = write_cloud(arena, cloud, T, 0)
        assert root == first + tree.root // PLACES
        ours, theirs = (
            array.reshape(-1, NODE_ROWS, 8)[k : k + arena.n_nodes].copy() for array, k in ((nodes, first), (arena.nodes, 0))
        )
        ours[cloud_trees._lowest(n)[0] :, CHILD] -= PLACES * first
        assert np.array_equal(ours, theirs, equal_nan=True)


def test_a_scene_of_few_solids_has_no_tree_on_the_device(panda, on_gpu, q):
    world = ulna.World()
    world.add("few", ulna.PointCloud(wall(1, 15), 0.03))
    assert not on_gpu._scenes.of(world, True, np.float64, 0).sizes[-1]
    check(panda, on_gpu, q, world)


def test_a_robot_over_float32_checks_many_solids_in_float64(panda, q):
    on_gpu, q = panda.on_gpu(float32=True), q.astype(np.float32).astype(np.float64)
    for world in (terrain(), seen()):
        check(panda, on_gpu, q, world)
        hits = on_gpu.in_collision(cuda.to_device(q.astype(np.float32)), world).copy_to_host()
        assert (hits == panda.in_collision(q, world))[np.abs(panda.signed_distance(q, world)) > 1e-9].all()
