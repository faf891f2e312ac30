"""The robot's boxes against the world's: forward kinematics and the box test of the twins, put together."""

import numpy as np
import pytest

import naive
from close import assert_close
from ulna.collision.checker import NO_PAIRS
from ulna.kernels.layout import BASE
from ulna.kernels.robot_boxes import contacts_one
from ulna.kernels.verdict import FREE, OUT_OF_RANGE, OVERLAPS, overlap_batch, overlap_one

N = 20


@pytest.fixture(scope="module")
def boxes(panda):
    return panda._checker.bodies.table


@pytest.fixture
def objects(rng):
    """Four boxes around the arm: poses and half extents."""
    poses = [naive.transform(naive.rotation(rng.normal(size=3), rng.uniform(-3, 3)), rng.uniform(-0.7, 0.7, 3)) for _ in range(4)]
    return list(zip(poses, rng.uniform(0.02, 0.12, (4, 3)), strict=True))


def table_of(objects):
    return np.array([[*T[:3].ravel(), BASE, 0.0, *half] for T, half in objects]).reshape(-1, 17)


def against(n_objects):
    """Every one of the twelve boxes with every object."""
    return np.array([(k, 12 + w) for k in range(12) for w in range(n_objects)])


def naive_gaps(panda, q, objects):
    """The widest gap of every pair: boxes of the robot down, objects across."""
    poses = dict(zip(panda.link_names, naive.link_poses(panda.description, q), strict=True))
    bodies = [(poses[link.name] @ body.pose, body.shape) for link in panda.description.links for body in link.collisions]
    return np.array([[naive.gaps_of_boxes(T, np.array(s.extents) / 2, T_w, h).max() for T_w, h in objects] for T, s in bodies])


def configurations(panda, rng, n=N):
    return rng.uniform(panda.lower, panda.upper, (n, 7))


def test_the_verdict_is_that_of_every_pair(panda, boxes, objects, rng):
    q, world, hits = configurations(panda, rng), table_of(objects), np.empty(N, dtype=np.bool_)
    expected = np.array([(naive_gaps(panda, x, objects) <= 0).any() for x in q])
    assert 0.1 < expected.mean() < 0.9
    assert overlap_batch(panda.tree.joints, boxes, NO_PAIRS, world, q, hits)
    assert np.array_equal(hits, expected)
    ones = [overlap_one(panda.tree.joints, boxes, NO_PAIRS, world, x) for x in q]
    assert ones == [OVERLAPS if hit else FREE for hit in expected]


def test_every_gap_is_that_of_the_twin_and_its_normal_leads_out(panda, boxes, objects, rng):
    for q in configurations(panda, rng, 4):
        found = np.empty((48, 4))
        assert contacts_one(panda.tree.joints, boxes, table_of(objects), against(4), q, found)
        assert_close(found[:, 0].reshape(12, 4), naive_gaps(panda, q, objects), atol=1e-12)
        assert_close(np.linalg.norm(found[:, 1:], axis=1), 1, atol=1e-13)


def gap_to(panda, boxes, q, T, half):
    found = np.empty((12, 4))
    assert contacts_one(panda.tree.joints, boxes, table_of([(T, half)]), against(1), q, found)
    return found[:, 0], found[:, 1:]


def test_moving_out_along_the_normal_by_the_depth_just_parts_a_pair_and_no_way_is_shorter(panda, boxes, rng):
    half, seen = np.array([0.15, 0.1, 0.08]), set()
    for q in configurations(panda, rng, 8):
        near = naive.link_poses(panda.description, q)[rng.integers(1, 8), :3, 3]
        T = naive.transform(naive.rotation(rng.normal(size=3), 2.0), near + rng.uniform(-0.1, 0.1, 3))
        gaps, normals = gap_to(panda, boxes, q, T, half)
        for k in np.flatnonzero(gaps < -1e-4):
            seen.add(k)
            out = naive.transform(p=-gaps[k] * normals[k])
            assert_close(gap_to(panda, boxes, q, out @ T, half)[0][k], 0, atol=1e-12)
            for direction in rng.normal(size=(10, 3)):
                shorter = naive.transform(p=-0.999 * gaps[k] * direction / np.linalg.norm(direction))
                assert gap_to(panda, boxes, q, shorter @ T, half)[0][k] < 0
    assert len(seen) >= 6


def test_an_empty_world_is_free(panda, boxes, rng):
    q, hits = configurations(panda, rng, 9), np.ones(9, dtype=np.bool_)
    assert overlap_batch(panda.tree.joints, boxes, NO_PAIRS, table_of([]), q, hits)
    assert not hits.any()
    assert overlap_one(panda.tree.joints, boxes, NO_PAIRS, table_of([]), q[0]) == FREE


@pytest.mark.parametrize("k", range(12))
def test_a_crumb_within_any_box_of_the_robot_is_met(panda, boxes, rng, k):
    """The checkers that compare surfaces miss a body that lies wholly inside another."""
    q, index = configurations(panda, rng, 1), -1
    for link, T in zip(panda.description.links, naive.link_poses(panda.description, q[0]), strict=True):
        for body in link.collisions:
            index += 1
            if index == k:
                crumb = T @ body.pose, np.full(3, 1e-4)
    gaps, _ = gap_to(panda, boxes, q[0], *crumb)
    assert gaps[k] < -1e-2
    assert overlap_one(panda.tree.joints, boxes, NO_PAIRS, table_of([crumb]), q[0]) == OVERLAPS


@pytest.mark.parametrize("bad", [np.nan, np.inf, 2e6])
def test_an_entry_out_of_range_is_told_and_never_free(panda, boxes, objects, rng, bad):
    q = configurations(panda, rng, 9)
    q[8, 3] = bad
    world = table_of(objects)
    with np.errstate(invalid="ignore"):
        assert not overlap_batch(panda.tree.joints, boxes, NO_PAIRS, world, q, np.empty(9, dtype=np.bool_))
        assert overlap_one(panda.tree.joints, boxes, NO_PAIRS, world, q[8]) == OUT_OF_RANGE
        assert not contacts_one(panda.tree.joints, boxes, world, against(4), q[8], np.empty((48, 4)))
