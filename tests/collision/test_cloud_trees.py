"""Clouds of every form against scipy's k-d tree: a ball that slides along three axes, verdict, distance and edge."""

import numpy as np
import pytest

import ulna
from assertions import assert_close
from matrix import matrix
from ulna.description.robot_description import Body, Description, Joint, JointType, Limits, Link

spatial = pytest.importorskip("scipy.spatial")
RADIUS = 0.02


def scattered(rng):
    return rng.uniform(-1, 1, (20_000, 3))


def surface(rng):
    u, v = rng.uniform(-1, 1, (2, 30_000))
    return np.column_stack([u, v, 0.2 * np.sin(5 * u) * np.cos(4 * v)])


def one(rng):
    return rng.uniform(-1, 1, (1, 3))


def equal(rng):
    return np.tile(rng.uniform(-1, 1, 3), (100_000, 1))


def line(rng):
    return rng.uniform(-1, 1, (5000, 1)) * [1.0, 0.5, -0.2]


def plane(rng):
    return np.column_stack([rng.uniform(-1, 1, (5000, 2)), np.full(5000, 0.25)])


def far_away(rng):
    return np.concatenate([rng.uniform(-1, 1, (3000, 3)), rng.uniform(-1e6, 1e6, (50, 3)), [(1e6, 1e6, 1e6), (-1e6, 0, 0)]])


def geometric(rng):
    return np.concatenate([rng.normal(size=(40, 3)) * 10.0 ** -np.arange(40)[:, None] for _ in range(50)])


CLOUDS = [scattered, surface, one, equal, line, plane, far_away, geometric]


def sliding_ball(radius):
    """A robot that is one ball, which three joints slide anywhere."""
    ball = Body("ball", ulna.Sphere(radius), np.eye(4))
    links = Link("a"), Link("b"), Link("c"), Link("d", collisions=(ball,))
    slide, wide = JointType("prismatic"), Limits(-1e6, 1e6)
    joints = tuple(
        Joint(f"{k}", slide, links[k].name, links[k + 1].name, np.eye(4), axis, limits=wide) for k, axis in enumerate(np.eye(3))
    )
    return ulna.Robot(Description("ball", links, joints))


@pytest.mark.slow
@pytest.mark.parametrize("make", CLOUDS)
@pytest.mark.parametrize("radius", matrix([0.0, 0.003, 0.4], [0.003]))
def test_verdicts_and_distances_are_those_of_a_k_d_tree(rng, make, radius):
    points = make(rng)
    robot, world = sliding_ball(radius), ulna.World()
    world.add("cloud", ulna.PointCloud(points, RADIUS))
    near = points[rng.integers(len(points), size=300)] + rng.normal(size=(300, 3)) * rng.choice([1e-3, 0.03, 0.5], (300, 1))
    q = np.concatenate([rng.uniform(-1.2, 1.2, (300, 3)), near[(np.abs(near) <= 9e5).all(axis=1)]])
    expected = spatial.cKDTree(points).query(q)[0] - RADIUS - radius
    tolerance = 1e-9 if make is far_away else 1e-12
    assert_close(robot.signed_distance(q, world), expected, atol=tolerance)
    clear = np.abs(expected) > tolerance
    assert np.array_equal(robot.in_collision(q, world)[clear], (expected <= 0)[clear])
    one_by_one = [robot.signed_distance(each, world) for each in q[::50]]
    assert_close(np.array(one_by_one), expected[::50], atol=tolerance)


@pytest.mark.parametrize("make", [scattered, surface, line, plane])
def test_edges_are_free_where_no_sample_of_them_touches(rng, make):
    points = make(rng)
    robot, world, tree = sliding_ball(0.01), ulna.World(), spatial.cKDTree(points)
    world.add("cloud", ulna.PointCloud(points, RADIUS))
    a = points[rng.integers(len(points), size=60)] + rng.normal(size=(60, 3)) * 0.06
    b = a + rng.normal(size=(60, 3)) * 0.05
    report = robot.edge_in_collision(a, b, world)
    t = np.linspace(0, 1, 400)[:, None, None]
    least = (tree.query((a + t * (b - a)).reshape(-1, 3))[0] - RADIUS - 0.01).reshape(400, 60).min(axis=0)
    assert (least[~report.in_collision] > 0).all(), "certified to be free"
    assert (least[report.in_collision] < 2e-3).all(), "and in contact only where a sample nearly is"
    assert 0 < report.in_collision.sum() < 60


def test_a_cloud_takes_at_most_forty_bytes_a_point(rng):
    world = ulna.World()
    world.add("cloud", ulna.PointCloud(rng.uniform(-1, 1, (100_000, 3)), 0.01))
    objects = world.objects()
    n_nodes = objects.layout.root // 4 + 1
    assert n_nodes * 7 * 64 <= 40 * 100_000


def test_each_ball_of_a_cloud_is_found_once(rng):
    for n in (1, 7, 8, 9, 16, 17, 63, 64, 65, 513, 1000):
        points = rng.uniform(-1, 1, (n, 3))
        world = ulna.World()
        world.add("cloud", ulna.PointCloud(points, 0.01))
        objects = world.objects()
        assert len(set(objects.numbers.tolist())) == n
        assert sorted(objects.solids[:, 3:12:4].tolist()) == sorted(points.tolist())
        assert set(objects.solids[:, 18]) == {0.01}
