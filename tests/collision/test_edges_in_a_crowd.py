"""Edges and plans among very many near objects: certified, the same verdict from both, and no contact at any sample."""

import numpy as np
import pytest

import ulna


def seen_by_a_camera(rng, n):
    """Points on a table and on two walls on it, with noise, as a depth camera gives them."""
    table = np.column_stack([rng.uniform(0.25, 0.9, n), rng.uniform(-0.5, 0.5, n), np.zeros(n)])
    along, height = rng.uniform(-0.15, 0.15, n // 4), rng.uniform(0, 0.15, n // 4)
    walls = [np.column_stack([0.55 + along, np.full(n // 4, side), height]) for side in (-0.15, 0.15)]
    points = np.concatenate([table, *walls]) + rng.normal(size=(n + 2 * (n // 4), 3)) * 1e-3
    world = ulna.World()
    world.add("cloud", ulna.PointCloud(points, 0.005))
    return world


def terrain(rng):
    world = ulna.World()
    world.add("terrain", ulna.HeightMap(rng.uniform(0, 0.08, (75, 120)), 0.012, -0.2), ulna.pose((0.55, 0, 0)))
    return world


def many_balls(rng):
    world = ulna.World()
    for k, place in enumerate(rng.uniform((0.3, -0.5, -0.1), (0.8, 0.5, 0.18), (1000, 3))):
        world.add(f"{k}", ulna.Sphere(0.01), ulna.pose(place))
    return world


@pytest.fixture(params=[lambda rng: seen_by_a_camera(rng, 10_000), terrain, many_balls], ids=["cloud", "height map", "spheres"])
def crowded(request, panda, rng):
    """A world, and configurations of the arm that are free in it, the hand low over the table."""
    world = request.param(rng)
    T = [ulna.pose(xyz, (np.pi, 0, yaw)) for *xyz, yaw in rng.uniform((0.35, -0.35, 0.1, -1), (0.65, 0.35, 0.4, 1), (200, 4))]
    q = panda.inverse_kinematics(T, panda.home).q
    return world, q[~panda.in_collision(q, world)]


def test_the_planner_decides_on_an_edge_as_edge_in_collision_does(panda, crowded):
    world, q = crowded
    ends = np.roll(q, 1, axis=0)
    edges = panda.edge_in_collision(q, ends, world)
    assert edges.in_collision.any()
    assert not edges.in_collision.all()
    for a, b, touches in zip(q, ends, edges.in_collision, strict=True):
        straight = panda.plan(a, b, world, max_checks=1)
        assert bool(straight) is not bool(touches)
        assert touches or straight.certified


def test_no_sample_of_a_free_edge_touches_and_a_contact_is_one(panda, crowded):
    world, q = crowded
    ends = np.roll(q, 1, axis=0)
    edges, t = panda.edge_in_collision(q, ends, world), np.linspace(0, 1, 201)[:, None]
    for a, b, touches, free in zip(q, ends, edges.in_collision, edges.free_until, strict=True):
        hits = panda.in_collision(a + t * (b - a), world)
        assert touches or not hits.any()
        assert free <= (t[np.argmax(hits), 0] if hits.any() else 1.0)
    stopped = panda.signed_distance(edges.q[edges.in_collision], world)
    assert (stopped > 0).all()
    assert stopped.max() < 1e-4, "the free part of an edge ends at a contact, to the resolution"


def test_plans_in_it_are_found_certified_and_free_at_all_samples(panda, crowded):
    world, q = crowded
    for k in range(20):
        plan = panda.plan(q[k], q[-1 - k], world, max_checks=2000)
        assert plan.certified
        for a, b in zip(plan.path[:-1], plan.path[1:], strict=True):
            assert not panda.in_collision(a + np.linspace(0, 1, 300)[:, None] * (b - a), world).any()


def test_a_motion_beside_a_cloud_is_free(panda, rng):
    world, end = seen_by_a_camera(rng, 10_000), panda.home + 0.8 * np.eye(7)[0]
    assert panda.plan(panda.home, end).trajectory(acceleration=2.0).is_free(world)


def test_a_hull_far_from_a_cloud_is_as_free_as_a_box(panda, rng):
    hull = ulna.ConvexMesh.from_points(rng.normal(size=(60, 3)) * 0.05)
    robot, world = panda.with_attached("stone", hull, ulna.pose((0, 0, 0.1)), touch_links=panda.link_names), ulna.World()
    world.add("cloud", ulna.PointCloud(rng.uniform((0.35, -0.2, -0.3), (0.7, 0.2, -0.15), (2000, 3)), 0.006))
    assert robot.plan(panda.home, panda.home + 0.3 * np.eye(7)[0], world, max_checks=20).certified


def test_a_cloud_that_links_may_touch_is_in_the_tree_and_another_link_may_not_touch_it(panda, rng):
    ball, end = rng.normal(size=(5000, 3)), panda.home + 1e-3
    points = panda.forward_kinematics(panda.home)[:3, 3] + 0.04 * ball / np.linalg.norm(ball, axis=1)[:, None]
    strict, touching, others = ulna.World(), ulna.World(), ulna.World()
    strict.add("dust", ulna.PointCloud(points, 0.002))
    links = {pair.link_a for pair in panda.check_collision(panda.home, strict, self_collision=False).pairs}
    touching.add("dust", ulna.PointCloud(points, 0.002), touch_links=links)
    objects = touching.objects()
    assert objects.first == objects.end
    assert not panda.in_collision(panda.home, touching)
    assert not panda.edge_in_collision(panda.home, end, touching)
    assert panda.plan(panda.home, end, touching).certified
    others.add("dust", ulna.PointCloud(points, 0.002), touch_links=links - {min(links)})
    assert panda.in_collision(panda.home, others)
    assert panda.edge_in_collision(panda.home, end, others).free_until == 0.0
