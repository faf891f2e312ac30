"""``robot.distances``: every near pair with its gradient, against Coal, differences, its own rows, and in a quadratic program."""

import numpy as np
import pytest
from scipy.optimize import minimize

import ulna
from assertions import assert_close
from coal_boxes import as_coal, distance
from ulna.collision.object_tables import MAX_UNINDEXED
from ulna.errors import GeometryError, InputError

SHAPES = [
    lambda rng: ulna.Box(rng.uniform(0.03, 0.2, 3)),
    lambda rng: ulna.Sphere(rng.uniform(0.02, 0.1)),
    lambda rng: ulna.Capsule(rng.uniform(0.02, 0.05), rng.uniform(0.05, 0.2)),
    lambda rng: ulna.Cylinder(rng.uniform(0.02, 0.06), rng.uniform(0.05, 0.2)),
    lambda rng: ulna.ConvexMesh.from_points(rng.normal(size=(15, 3)) * 0.06),
]
FIELDS = ("signed_distance", "witness_a", "witness_b", "normal", "gradient", "body_a", "body_b")


def world_of(rng, n, shapes, *, floor=False):
    world = ulna.World()
    for k in range(n):
        way = rng.normal(size=3)
        T = ulna.pose(way / np.linalg.norm(way) * rng.uniform(0.4, 1.2), rng.uniform(-3, 3, 3))
        world.add(f"{k}", shapes[k % len(shapes)](rng), T)
    if floor:
        world.add("floor", ulna.HalfSpace(), ulna.pose((0, 0, -0.02)), touch_links=["panda_link0", "panda_link1"])
    return world


@pytest.fixture(params=[40, 3 * MAX_UNINDEXED], ids=["few", "many"])
def boxes(request, rng):
    return world_of(rng, request.param, SHAPES[:1])


@pytest.fixture(params=[10, 3 * MAX_UNINDEXED], ids=["few", "many"])
def mixed(request, rng):
    return world_of(rng, request.param, SHAPES, floor=True)


def positions(panda, rng, n):
    return rng.uniform(panda.lower, panda.upper, (n, 7))


def test_it_has_exactly_the_pairs_that_coal_finds_so_near(panda, boxes, rng):
    extents = [body.shape.extents for link in panda.description.links for body in link.collisions]
    some = boxes.names[:40]
    objects = {name: as_coal(boxes.shape(name).extents, boxes.pose(name)) for name in some}
    found_any = 0
    for q in positions(panda, rng, 15):
        near = panda.distances(q, boxes, within=0.15, self_collision=False)
        found = dict(zip(zip(near.name_a, near.name_b, strict=True), near.signed_distance, strict=True))
        assert len(found) == len(near)
        for body, size, T in zip(panda.collision_names, extents, panda.collision_poses(q), strict=True):
            for name, other in objects.items():
                expected = distance(as_coal(size, T), other)
                assert ((body, name) in found) == (expected <= 0.15)
                if expected <= 0.15:
                    assert found[body, name] == pytest.approx(expected, rel=0, abs=1e-8)
                    found_any += 1
    assert found_any > 10


def test_they_are_the_pairs_of_a_report_in_its_order(panda, mixed, rng):
    for q in positions(panda, rng, 10):
        near, pairs = panda.distances(q, mixed, within=0.3), panda.check_collision(q, mixed, max_distance=0.3).pairs
        assert [(pair.name_a, pair.name_b) for pair in pairs] == list(zip(near.name_a, near.name_b, strict=True))
        for name in ("signed_distance", "witness_a", "witness_b", "normal"):
            assert np.array_equal(getattr(near, name), np.array([getattr(pair, name) for pair in pairs]))
        assert [pair.link_b is None for pair in pairs] == (near.body_b < 0).tolist()
        assert [panda.collision_names[k] for k in near.body_a] == list(near.name_a)
        assert [panda.collision_names[k] for k in near.body_b[near.body_b >= 0]] == [
            p.name_b for p in pairs if p.link_b is not None
        ]
        assert np.array_equal(near.signed_distance, np.sort(near.signed_distance))
        assert_close(near.witness_b - near.witness_a, near.signed_distance[:, None] * near.normal, atol=1e-9)


def test_all_pairs_come_with_infinity_and_the_nearest_is_that_of_signed_distance(panda, mixed, rng):
    on_floor = sum(len(link.collisions) for link in panda.description.links if link.name in mixed.touch_links("floor"))
    assert on_floor > 0
    for q in positions(panda, rng, 5):
        near = panda.distances(q, mixed, within=np.inf)
        assert len(near) == 12 * len(mixed.names) + 37 - on_floor
        assert_close(near.signed_distance[0], panda.signed_distance(q, mixed), atol=1e-12)


def by_pair(near):
    return {(a, b): k for k, (a, b) in enumerate(zip(near.name_a, near.name_b, strict=True))}


def test_every_gradient_is_that_of_differences_away_from_kinks(panda, rng):
    world, h, judged, overlapping = world_of(rng, 20, SHAPES, floor=True), 1e-6, 0, 0
    for q in positions(panda, rng, 12):
        here = panda.distances(q, world, within=0.15)
        around = [[panda.distances(q + side * h * axis, world, within=0.2) for side in (1, -1)] for axis in np.eye(7)]
        places = [[by_pair(near) for near in both] for both in around]
        for k, pair in enumerate(zip(here.name_a, here.name_b, strict=True)):
            d = np.array([
                [near.signed_distance[at[pair]] for near, at in zip(both, where, strict=True)]
                for both, where in zip(around, places, strict=True)
            ])  # fmt: skip
            if (np.abs(d.sum(axis=1) - 2 * here.signed_distance[k]) < 1e-9).all():
                assert_close(here.gradient[k], (d[:, 0] - d[:, 1]) / (2 * h), atol=2e-4)
                judged += 1
                overlapping += here.signed_distance[k] < 0
    assert judged > 100
    assert overlapping > 5


def test_a_batch_has_the_rows_of_its_configurations_bit_for_bit(panda, mixed, rng):
    q = positions(panda, rng, 150).reshape(3, 50, 7)
    with ulna.threads(2):
        whole = panda.distances(q, mixed, within=0.12)
    assert whole.offsets.shape == (151,)
    assert whole.offsets[0] == 0
    assert whole.offsets[-1] == len(whole)
    assert np.array_equal(np.bincount(whole.row, minlength=150), np.diff(whole.offsets))
    for i, one in enumerate(q.reshape(-1, 7)):
        near, part = panda.distances(one, mixed, within=0.12), slice(whole.offsets[i], whole.offsets[i + 1])
        assert near.offsets.tolist() == [0, len(near)]
        assert near.name_b == whole.name_b[part]
        for name in FIELDS:
            assert np.array_equal(getattr(near, name), getattr(whole, name)[part])


@pytest.mark.parametrize("n", [MAX_UNINDEXED // 2, 5 * MAX_UNINDEXED])
def test_of_a_cloud_each_body_has_its_nearest_ball(panda, rng, n):
    way = rng.normal(size=(n, 3))
    points = way / np.linalg.norm(way, axis=1)[:, None] * rng.uniform(0.4, 0.9, (n, 1))
    one, many, above = ulna.World(), ulna.World(), np.array([0, 0, 0.3])
    one.add("cloud", ulna.PointCloud(points, 0.02))
    one.add("other", ulna.PointCloud(points + above, 0.02))
    for k, point in enumerate(points):
        many.add(f"cloud {k}", ulna.Sphere(0.02), ulna.pose(point))
        many.add(f"other {k}", ulna.Sphere(0.02), ulna.pose(point + above))
    for q in positions(panda, rng, 10):
        near, each = (panda.distances(q, world, within=0.2, self_collision=False) for world in (one, many))
        least = {}
        for a, b, d in zip(each.name_a, each.name_b, each.signed_distance, strict=True):
            least.setdefault((a, b.split()[0]), d)
        assert set(zip(near.name_a, near.name_b, strict=True)) == set(least)
        assert len(near) == len(least)
        expected = [least[pair] for pair in zip(near.name_a, near.name_b, strict=True)]
        assert_close(near.signed_distance, expected, atol=1e-12)


def test_of_a_height_map_too(panda, rng):
    world = ulna.World()
    world.add("terrain", ulna.HeightMap(rng.uniform(0, 0.2, (20, 20)), 0.05), ulna.pose((0.4, 0, 0)))
    near = panda.distances(positions(panda, rng, 1)[0], world, within=0.5, self_collision=False)
    assert 1 < len(near) == len(set(near.name_a)) <= 12


def test_where_there_is_nothing_near_it_is_empty(panda):
    for world in (ulna.World(), None):
        near = panda.distances(panda.home, world, within=0.0)
        assert (len(near), near.gradient.shape, near.name_a, near.row.shape) == (0, (0, 7), (), (0,))
    far = panda.distances(np.zeros((0, 7)), ulna.World())
    assert far.offsets.tolist() == [0]
    assert len(panda.distances(panda.home, ulna.World(), self_collision=False, within=np.inf)) == 0


@pytest.mark.parametrize("within", [-1, np.nan, "far", True, None])
def test_a_value_that_is_not_a_distance_is_refused(panda, within):
    with pytest.raises(InputError, match="within"):
        panda.distances(panda.home, within=within)


def test_wrong_positions_worlds_and_robots_are_refused(panda):
    q = np.zeros((100, 7))
    q[70, 2] = np.inf
    with pytest.raises(InputError, match=r"q\[70, 2\]"):
        panda.distances(q)
    with pytest.raises(InputError, match=r"q\[0\]"):
        panda.distances(np.full(7, np.nan))
    with pytest.raises(InputError, match="shape"):
        panda.distances(np.zeros(6))
    with pytest.raises(InputError, match="world"):
        panda.distances(panda.home, "world")
    with pytest.raises(InputError, match="nothing to check"):
        panda.distances(panda.home, self_collision=False)
    with pytest.raises(GeometryError):
        ulna.Robot.from_dh([(0, 0, 0, 0)]).distances([0.0])


def test_a_quadratic_program_of_its_rows_keeps_a_margin_where_the_plain_motion_collides(panda):
    """The hand is to go 0.3 m down, through a crate: each step is the least change of that one which leaves every pair 2 cm."""
    world = ulna.World()
    world.add("crate", ulna.Box((0.2, 0.4, 0.2)), ulna.pose((0.45, 0, 0.2)))
    margin, down = 0.02, np.array([0, 0, -0.01, 0, 0, 0])
    nearest = {}
    for kept in (False, True):
        q, nearest[kept] = np.array(panda.home), np.inf
        for _ in range(30):
            wanted = np.linalg.pinv(panda.jacobian(q)) @ down
            near = panda.distances(q, world, within=0.1)
            room = near.signed_distance - margin
            rule = {
                "type": "ineq",
                "fun": lambda dq, near=near, room=room: room + near.gradient @ dq,
                "jac": lambda _, near=near: near.gradient,
            }
            found = minimize(
                lambda dq, wanted=wanted: np.sum((dq - wanted) ** 2),
                np.zeros(7),
                jac=lambda dq, wanted=wanted: 2 * (dq - wanted),
                constraints=[rule] if kept and len(near) else [],
                method="SLSQP",
            )
            q = q + found.x
            nearest[kept] = min(nearest[kept], panda.signed_distance(q, world))
    assert nearest[False] < 0
    assert nearest[True] > margin - 0.005
