"""Point clouds and height maps: the same as their balls and columns one by one, told as one; what is no cloud is refused."""

import pickle

import numpy as np
import pytest

import ulna
from assertions import assert_close
from ulna.collision.object_tables import MAX_UNINDEXED
from ulna.errors import GeometryError, InputError

PLACE = ulna.pose((0.1, -0.1, 0.2), (0.4, -0.3, 1.0))
NARROW, WIDE = (ulna.pose(xyz, (0.03, -0.02, 1.0)) for xyz in ((0.6, 0.5, 0.3), (0.45, 0.4, -0.06)))
COUNTS = [MAX_UNINDEXED // 2, 3 * MAX_UNINDEXED]  # in no tree, and in one


def cloud_and_balls(rng, n):
    """A world with a cloud, and one with its points as balls of their own."""
    way = rng.normal(size=(n, 3))
    points = way / np.linalg.norm(way, axis=1)[:, None] * rng.uniform(0.5, 1.3, (n, 1))
    one, many = ulna.World(), ulna.World()
    one.add("cloud", ulna.PointCloud(points, 0.03), PLACE)
    for k, point in enumerate(points):
        many.add(f"{k}", ulna.Sphere(0.03), PLACE @ ulna.pose(point))
    return one, many


def map_and_columns(rng, n):
    """A world with a height map, and one with its cells as boxes of their own, placed by counting from a corner."""
    nx, ny, cell, bottom = n // 8, 8, 0.15, -0.5
    heights, T = rng.uniform(-0.4, 0.1, (nx, ny)), NARROW if n == COUNTS[0] else WIDE
    one, many = ulna.World(), ulna.World()
    one.add("terrain", ulna.HeightMap(heights, cell, bottom), T)
    for i in range(nx):
        for j in range(ny):
            tall = heights[i, j] - bottom
            x, y = (i + 0.5) * cell - nx * cell / 2, (j + 0.5) * cell - ny * cell / 2
            many.add(f"{i} {j}", ulna.Box((cell, cell, tall)), T @ ulna.pose((x, y, bottom + tall / 2)))
    return one, many


@pytest.fixture(
    params=[(kind, n) for kind in (cloud_and_balls, map_and_columns) for n in COUNTS], ids=lambda p: f"{p[0].__name__} {p[1]}"
)
def worlds(request, rng):
    make, n = request.param
    return make(rng, n)


def test_it_is_the_same_as_its_solids_one_by_one(panda, worlds, rng):
    one, many = worlds
    q = rng.uniform(panda.lower, panda.upper, (60, 7))
    hits = panda.in_collision(q, one, self_collision=False)
    assert 0 < hits.mean() < 1
    assert_close(hits, panda.in_collision(q, many, self_collision=False))
    distances = panda.signed_distance(q, one, self_collision=False)
    assert_close(distances, panda.signed_distance(q, many, self_collision=False), atol=1e-12)
    edges = [panda.edge_in_collision(q[:-1], q[1:], world, self_collision=False) for world in worlds]
    assert_close(edges[0].in_collision, edges[1].in_collision)


def test_a_report_has_the_nearest_of_it_once_for_each_shape_of_the_robot(panda, worlds, rng):
    one, many = worlds
    for q in rng.uniform(panda.lower, panda.upper, (10, 7)):
        told = panda.check_collision(q, one, self_collision=False, max_distance=0.3).pairs
        least = {}
        for pair in panda.check_collision(q, many, self_collision=False, max_distance=0.3).pairs:
            least.setdefault(pair.name_a, pair.signed_distance)
        assert {pair.name_b for pair in told} <= set(one.names)
        assert {pair.name_a: pytest.approx(pair.signed_distance, abs=1e-12) for pair in told} == least


def test_it_may_stand_among_other_objects(panda):
    world = ulna.World()
    world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -1)))
    world.add("hull", ulna.ConvexMesh(np.vstack([np.eye(3), -np.eye(3)]) * 0.05), ulna.pose((5, 0, 0)))
    world.add("cloud", ulna.PointCloud([(0.3, 0, 0.5), (9, 9, 9)], 0.01))
    world.add("later hull", ulna.ConvexMesh(np.vstack([np.eye(3), -np.eye(3)]) * 0.05), ulna.pose((0, 0, 0.6)))
    touched = {pair.name_b for pair in panda.check_collision(panda.home, world, self_collision=False).pairs}
    assert touched == {"cloud", "later hull"}


def test_a_cell_without_height_is_flat_not_gone(panda):
    world = ulna.World()
    world.add("table", ulna.HeightMap(np.full((8, 8), 0.3), cell=0.4))
    assert panda.in_collision(panda.home, world, self_collision=False)
    world.move("table", ulna.pose((0, 0, -0.5)))
    assert panda.signed_distance(panda.home, world, self_collision=False) == pytest.approx(0.2, abs=1e-12)  # to the base's box


@pytest.mark.parametrize("cloud", [ulna.PointCloud([(1, 2, 3)], 0.1), ulna.HeightMap([[1, 2], [3, 4]], 0.1, 0.5)])
def test_it_is_frozen_and_goes_to_another_process(cloud):
    numbers = cloud.points if isinstance(cloud, ulna.PointCloud) else cloud.heights
    with pytest.raises(ValueError, match="read-only"):
        numbers[0, 0] = 7
    assert repr(pickle.loads(pickle.dumps(cloud))) == repr(cloud)  # noqa: S301


def test_nothing_can_hold_it(panda):
    with pytest.raises(GeometryError, match="PointCloud, which cannot be attached"):
        panda.with_attached("cloud", ulna.PointCloud([(0, 0, 0)], 0.1), np.eye(4))


@pytest.mark.parametrize(
    "points", [[1, 2, 3], [[1, 2]], [[[[1, 2, 3]]]], [[np.nan, 0, 0]], [[np.inf, 0, 0]], [[2e6, 0, 0]], "cloud", None]
)
def test_what_is_no_cloud_is_refused_by_name(points):
    with pytest.raises(InputError, match=r"^points: "):
        ulna.PointCloud(points, 0.1)


@pytest.mark.parametrize("radius", [-0.1, np.nan, np.inf, "wide", None, [0.1, 0.2]])
def test_what_is_no_radius_is_refused_by_name(radius):
    with pytest.raises(InputError, match=r"^radius: "):
        ulna.PointCloud([(0, 0, 0)], radius)


@pytest.mark.parametrize(
    ("heights", "cell", "bottom", "name"),
    [
        ([1, 2], 0.1, None, "heights"),
        ([[]], 0.1, None, "heights"),
        ([[np.nan]], 0.1, None, "heights"),
        ([[1.0]], -0.1, None, "cell"),
        ([[1.0]], 0.1, np.nan, "bottom"),
        ([[1.0, 0.2]], 0.1, 0.3, "bottom"),
    ],
)
def test_what_is_no_height_map_is_refused_by_name(heights, cell, bottom, name):
    with pytest.raises(InputError, match=rf"^{name}: "):
        ulna.HeightMap(heights, cell, bottom)


@pytest.mark.parametrize("n", COUNTS)
def test_a_pair_names_the_point_of_the_cloud(panda, rng, n):
    one, many = cloud_and_balls(rng, n)
    one.add("before it", ulna.PointCloud(rng.uniform(5, 6, (500, 3)), 0.01))
    one.move("cloud", PLACE)  # now it is written behind the other
    named = 0
    for q in panda.random(20, seed=3):
        pairs = panda.check_collision(q, one, max_distance=0.2, self_collision=False).pairs
        nearest = {
            pair.name_a: pair.name_b for pair in panda.check_collision(q, many, max_distance=0.2).pairs[::-1] if not pair.link_b
        }
        for pair in pairs:
            assert nearest[pair.name_a] == str(pair.point)
            middle = PLACE @ [*one.shape("cloud").points[pair.point], 1.0]
            assert_close(pair.witness_b + 0.03 * pair.normal, middle[:3], atol=1e-12)
            assert pickle.loads(pickle.dumps(pair)).point == pair.point  # noqa: S301 - our own
            named += 1
    assert named > 20
    assert panda.check_collision(panda.home, many, max_distance=2.0).pairs[0].point is None
