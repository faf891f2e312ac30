"""Worlds of many solids on a GPU, such as clouds of points, against the robot on the CPU.

See ``test_gpu_robot.py``. In the simulator few solids already make a BVH.
"""

import os

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import ulna
from ulna.gpu import scenes, search

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"
N = 6 if SIMULATED else 20_000
POINTS = 200 if SIMULATED else 100_000
RADIUS = 0.03 if SIMULATED else 0.004
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)
pytestmark = pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")  # of missing children, in kernels as plain Python


@pytest.fixture(scope="module")
def panda():
    return ulna.load("panda")


@pytest.fixture(scope="module")
def on_gpu(panda):
    return panda.on_gpu()


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
    world.add("crowd", ulna.PointCloud(wall(2, POINTS // 2).astype(np.float32), RADIUS), ulna.pose((-0.9, 0.1, 0.0), (0, 0, 2.0)))
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
    assert on_gpu._scenes.of(world, True, np.float64).sizes[-1], "the scene has a BVH"
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


def test_a_change_of_a_world_is_seen_and_copies_what_is_new_alone(panda, on_gpu, q, monkeypatch):
    world, copied = furnished(), []
    check(panda, on_gpu, q, world)
    monkeypatch.setattr(scenes, "few_numbers_below", noted(copied, scenes.few_numbers_below))
    of = scenes.ArenaCopy._copied

    def counted(self, name, part, end):
        there, first = of(self, name, part, end)
        copied.append((name, end - first))
        return there, first

    monkeypatch.setattr(scenes.ArenaCopy, "_copied", counted)
    for change in (
        lambda: world.move("box", ulna.pose((-0.3, -0.3, 0.5))),
        lambda: world.update("wall", wall(3, POINTS // 4)),
        lambda: world.move("crowd", ulna.pose((0.1, 0.0, 0.1))),
        lambda: world.remove("ground"),
        lambda: world.add("post", ulna.Capsule(0.05, 0.5), ulna.pose((0.4, 0.0, 0.6))),
    ):
        change()
        copied.clear()
        check(panda, on_gpu, q, world)
        rows = {name: n for name, n in copied if name != "tree"}
        assert 0 < rows["objects"] < 20
        assert rows["nodes"] < len(world.objects().layout.nodes) / 2, "the other nodes are there already"
        assert len(copied) == 4, "the second call finds the scene on the device"
    for k in range(4):  # until the arena is full and another one takes its place
        world.update("wall", wall(k))
        check(panda, on_gpu, q[:2], world)
    assert max(n for name, n in copied if name == "nodes") > 7


def noted(calls, function):
    def call(*arguments):
        calls.append(("tree", 0))
        return function(*arguments)

    return call


def test_a_scene_of_few_solids_has_no_tree_on_the_device(panda, on_gpu, q):
    world = ulna.World()
    world.add("few", ulna.PointCloud(wall(1, 15), 0.03))
    assert not on_gpu._scenes.of(world, True, np.float64).sizes[-1]
    check(panda, on_gpu, q, world)


def test_a_robot_over_float32_checks_many_solids_in_float64(panda, q):
    on_gpu, q = panda.on_gpu(float32=True), q.astype(np.float32).astype(np.float64)
    for world in (terrain(), seen()):
        check(panda, on_gpu, q, world)
        hits = on_gpu.in_collision(cuda.to_device(q.astype(np.float32)), world).copy_to_host()
        assert (hits == panda.in_collision(q, world))[np.abs(panda.signed_distance(q, world)) > 1e-9].all()
