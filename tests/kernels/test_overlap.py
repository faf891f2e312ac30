"""The robot's boxes against the world's and each other: forward kinematics and the box test of the twins, put together."""

import numpy as np
import pytest

import formulas
from assertions import assert_close
from ulna.collision.entries import contacts, overlap
from ulna.collision.object_tables import MAX_UNINDEXED, make_objects
from ulna.description.shapes import Box
from ulna.kernels.collision.collision_layout import (
    CONTACT_WIDTH,
    DISTANCE,
    FREE,
    NORMAL,
    OUT_OF_RANGE,
    OVERLAPS,
    WITNESS_A,
    WITNESS_B,
)
from ulna.kernels.collision.scene import Scene

contacts_each = contacts.contacts_each
overlap_batch = overlap.overlap_batch
overlap_one = overlap.overlap_one
N = 20
NO_PAIRS = np.zeros((0, 2), dtype=np.int64)


@pytest.fixture(scope="module")
def bodies(panda):
    return panda._checker.bodies


def scattered(rng, n, size, reach=0.9):
    """Boxes around the arm, none where its foot stands: poses and half extents."""
    places = rng.normal(size=(n, 3))
    places *= rng.uniform(0.55, reach, (n, 1)) / np.linalg.norm(places, axis=1, keepdims=True)
    poses = [formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3)), place) for place in places]
    return list(zip(poses, size * rng.uniform(0.2, 1, (n, 3)), strict=True))


@pytest.fixture
def objects(rng):
    return scattered(rng, 4, 0.15)


def table_of(objects):
    shapes = {str(k): Box(2 * half) for k, (_, half) in enumerate(objects)}
    return make_objects(shapes, {str(k): T for k, (T, _) in enumerate(objects)}, {})


def scene(panda, bodies, world, pairs=NO_PAIRS):
    no_touch = np.zeros((len(bodies.table), 1), dtype=bool)
    layout = world.layout
    of_world = layout.table, None, layout.nodes, layout.root, world.first, world.end
    return Scene(panda.tree.joints, bodies.table, None, pairs, *of_world, no_touch)


def placed(panda, q):
    poses = dict(zip(panda.link_names, formulas.link_poses(panda.description, q), strict=True))
    return [(poses[link.name] @ body.pose, body.shape) for link in panda.description.links for body in link.collisions]


def naive_gaps(panda, q, objects):
    """The widest gap of every pair: boxes of the robot down, objects across."""
    return np.array(
        [[formulas.gaps_of_boxes(T, np.array(s.extents) / 2, T_w, h).max() for T_w, h in objects] for T, s in placed(panda, q)]
    )


def configurations(panda, rng, n=N):
    return rng.uniform(panda.lower, panda.upper, (n, 7))


def overlaps(panda, bodies, world, q, pairs=NO_PAIRS):
    """Those of the batch, which are those of one after the other."""
    hits = np.empty(len(q), dtype=np.bool_)
    assert overlap_batch(scene(panda, bodies, world, pairs), q, hits)
    assert [overlap_one(scene(panda, bodies, world, pairs), x) for x in q] == [OVERLAPS if hit else FREE for hit in hits]
    return hits


def test_it_overlaps_where_any_pair_does(panda, bodies, objects, rng):
    q = configurations(panda, rng)
    expected = np.array([(naive_gaps(panda, x, objects) <= 0).any() for x in q])
    assert 0.1 < expected.mean() < 0.9
    assert np.array_equal(overlaps(panda, bodies, table_of(objects), q), expected)


def test_a_bvh_of_objects_overlaps_where_any_object_does(panda, bodies, rng):
    for n in (MAX_UNINDEXED, MAX_UNINDEXED + 1, 3 * MAX_UNINDEXED):
        objects, q = scattered(rng, n, 0.02, reach=1.5), configurations(panda, rng, 24)
        world = table_of(objects)
        assert (world.layout.root >= 0) == (n > MAX_UNINDEXED)
        expected = np.zeros(24, dtype=bool)
        for k in range(0, n, MAX_UNINDEXED):
            expected |= overlaps(panda, bodies, table_of(objects[k : k + MAX_UNINDEXED]), q)
        assert 0 < expected.mean() < 1
        assert np.array_equal(overlaps(panda, bodies, world, q), expected)


def test_pairs_of_the_robot_are_met_too(panda, bodies, rng):
    q, pairs = configurations(panda, rng, 60), np.array([(4, 10), (0, 11), (2, 9)])
    expected = []
    for x in q:
        at = [(T, np.array(s.extents) / 2) for T, s in placed(panda, x)]
        expected.append(any(formulas.gaps_of_boxes(*at[i], *at[j]).max() <= 0 for i, j in pairs))
    assert any(expected)
    assert overlaps(panda, bodies, table_of([]), q, pairs).tolist() == expected


def against(world):
    """Every one of the twelve boxes with every object."""
    return np.array([(k, 12 + w) for k in range(12) for w in world.numbers])


def contacts(panda, bodies, world, q):
    found = np.empty((12 * len(world.layout.names), CONTACT_WIDTH))
    assert measure(panda, bodies, world, q, found)
    return found


def measure(panda, bodies, world, q, found):
    rows = np.zeros(len(found), dtype=np.int64)
    return contacts_each(scene(panda, bodies, world), q[None], rows, against(world), found, np.empty((0, 7)))


def test_every_depth_is_that_of_the_twin_and_its_witnesses_stand_that_far_apart(panda, bodies, objects, rng):
    for q in configurations(panda, rng, 4):
        found, gaps = contacts(panda, bodies, table_of(objects), q), naive_gaps(panda, q, objects).ravel()
        distance, normal = found[:, DISTANCE], found[:, NORMAL : NORMAL + 3]
        assert_close(distance[gaps <= 0], gaps[gaps <= 0], atol=1e-12)
        assert (distance[gaps > 0] >= gaps[gaps > 0] - 1e-12).all()
        assert_close(np.linalg.norm(normal, axis=1), 1, atol=1e-12)
        between = found[:, WITNESS_B : WITNESS_B + 3] - found[:, WITNESS_A : WITNESS_A + 3]
        assert_close(between, distance[:, None] * normal, atol=1e-12)


def contact_with(panda, bodies, q, T, half):
    found = contacts(panda, bodies, table_of([(T, half)]), q)
    return found[:, DISTANCE], found[:, NORMAL : NORMAL + 3]


def test_moving_out_along_the_normal_by_the_depth_just_parts_a_pair_and_no_way_is_shorter(panda, bodies, rng):
    half, seen = np.array([0.15, 0.1, 0.08]), set()
    for q in configurations(panda, rng, 8):
        near = formulas.link_poses(panda.description, q)[rng.integers(1, 8), :3, 3]
        T = formulas.transform(formulas.rotation(rng.normal(size=3), 2.0), near + rng.uniform(-0.1, 0.1, 3))
        gaps, normals = contact_with(panda, bodies, q, T, half)
        for k in np.flatnonzero(gaps < -1e-4):
            seen.add(k)
            out = formulas.transform(p=-gaps[k] * normals[k])
            assert_close(contact_with(panda, bodies, q, out @ T, half)[0][k], 0, atol=1e-12)
            for direction in rng.normal(size=(10, 3)):
                shorter = formulas.transform(p=-0.999 * gaps[k] * direction / np.linalg.norm(direction))
                assert contact_with(panda, bodies, q, shorter @ T, half)[0][k] < 0
    assert len(seen) >= 6


def test_an_empty_world_is_free(panda, bodies, rng):
    assert not overlaps(panda, bodies, table_of([]), configurations(panda, rng, 9)).any()


@pytest.mark.parametrize("k", range(12))
def test_a_crumb_within_any_box_of_the_robot_is_met(panda, bodies, rng, k):
    """The checkers that compare surfaces miss a body that lies wholly inside another."""
    q = configurations(panda, rng, 1)
    crumb = placed(panda, q[0])[k][0], np.full(3, 1e-4)
    assert contact_with(panda, bodies, q[0], *crumb)[0][k] < -1e-2
    assert overlaps(panda, bodies, table_of([crumb]), q).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, 2e6])
@pytest.mark.parametrize("n", [4, MAX_UNINDEXED + 1])
def test_an_entry_out_of_range_is_reported_and_never_free(panda, bodies, rng, bad, n):
    q, world = configurations(panda, rng, 9), table_of(scattered(rng, n, 0.1))
    q[8, 3] = bad
    with np.errstate(invalid="ignore"):
        assert not overlap_batch(scene(panda, bodies, world), q, np.empty(9, dtype=np.bool_))
        assert overlap_one(scene(panda, bodies, world), q[8]) == OUT_OF_RANGE
        assert not measure(panda, bodies, world, q[8], np.empty((12 * n, CONTACT_WIDTH)))
