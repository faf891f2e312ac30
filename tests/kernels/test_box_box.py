"""Two boxes: the fifteen axes against the shadows of their corners, and what must hold for any two boxes."""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
from assertions import assert_close

I = np.eye(4)  # noqa: E741
HALF = np.array([0.5, 1.0, 2.0])


def ask(run, boxes):
    """Verdict, widest gap and its axis of many pairs (T_a, h, T_b, g)."""
    rows = [[*T_a[:3].ravel(), *h, *T_b[:3].ravel(), *g] for T_a, h, T_b, g in boxes]
    overlap, gap, axis = run(probes.two_boxes, np.transpose(rows), 3)
    return overlap == 1.0, gap, axis.astype(int)


def moved(*p):
    return formulas.transform(p=p)


def random_pose(rng, scale):
    return formulas.transform(formulas.rotation(rng.normal(size=3), rng.uniform(-np.pi, np.pi)), rng.normal(size=3) * scale)


def random_pairs(rng, n):
    """Pairs that are apart about as often as not."""
    return [(random_pose(rng, 1), rng.uniform(0.1, 1, 3), random_pose(rng, 1), rng.uniform(0.1, 1, 3)) for _ in range(n)]


@pytest.mark.slow
def test_the_widest_gap_is_that_of_the_corners_shadows(run, rng):
    pairs = random_pairs(rng, 600)
    gaps = np.array([formulas.gaps_of_boxes(*pair) for pair in pairs])
    overlap, gap, axis = ask(run, pairs)
    assert_close(gap, gaps.max(axis=1), atol=1e-12)
    assert np.array_equal(axis, gaps.argmax(axis=1))
    assert np.array_equal(overlap, gaps.max(axis=1) <= 0)
    assert 0.2 < overlap.mean() < 0.8
    assert set(axis) == set(range(15)), "some axis was never the widest: the sample proves nothing of it"


@pytest.mark.slow
@pytest.mark.parametrize("axis", range(15))
def test_each_axis_alone_can_separate_two_boxes(run, rng, axis):
    """Move B along the axis until the shadows are 1e-6 apart, or overlap by 1e-6; keep pairs that no other axis separates."""
    tried = 0
    while tried < 5:
        T_a, h, T_b, g = random_pairs(rng, 1)[0]
        A, B = T_a[:3, :3].T, T_b[:3, :3].T
        n = (*A, *B, *(np.cross(a, b) for a in A for b in B))[axis]
        n /= np.linalg.norm(n)
        n *= np.sign(n @ (T_b - T_a)[:3, 3])
        for gap in (1e-6, -1e-6):
            T = moved(*(n * (gap - formulas.gaps_of_boxes(T_a, h, T_b, g)[axis]))) @ T_b
            gaps = formulas.gaps_of_boxes(T_a, h, T, g)
            if np.delete(gaps, axis).max() > -1e-3:
                break
            overlap, found, widest = ask(run, [(T_a, h, T, g)])
            assert overlap[0] == (gap < 0)
            assert widest[0] == axis
            assert_close(found, gap, atol=1e-12)
            tried += 1


def test_a_box_within_another_overlaps_it(run, rng):
    small = HALF / 50
    inside = [(random_pose(rng, 0.05), HALF, random_pose(rng, 0.05), small) for _ in range(50)]
    overlap, gap, _ = ask(run, inside + [(T_b, g, T_a, h) for T_a, h, T_b, g in inside])
    assert overlap.all()
    assert (gap < -0.1).all()


def test_a_box_overlaps_itself_by_its_shortest_edge(run):
    overlap, gap, axis = ask(run, [(I, HALF, I, HALF), (I, HALF, formulas.transform(formulas.rotation((1, 0, 0), np.pi)), HALF)])
    assert overlap.all()
    assert_close(gap, -1.0, atol=1e-15)
    assert set(axis) <= {0, 3}


@pytest.mark.parametrize("k", range(3))
@pytest.mark.parametrize("side", [1, -1])
def test_boxes_that_touch_overlap_with_a_gap_of_zero(run, k, side):
    across = np.eye(3)[k] * side
    pairs = [(I, HALF, moved(*(across * 2 * HALF[k] * (1 + d))), HALF) for d in (0.0, 1e-6, -1e-6, 1e-3, -1e-3)]
    overlap, gap, axis = ask(run, pairs)
    assert list(overlap) == [True, False, True, False, True]
    assert_close(gap, 2 * HALF[k] * np.array([0, 1e-6, -1e-6, 1e-3, -1e-3]), atol=1e-15)
    assert set(axis) <= {k, k + 3}


def test_boxes_that_meet_at_an_edge_or_a_corner_touch(run):
    at_edge, at_corner = moved(2 * HALF[0], 2 * HALF[1], 0), moved(*(2 * HALF))
    overlap, gap, _ = ask(run, [(I, HALF, at_edge, HALF), (I, HALF, at_corner, HALF)])
    assert overlap.all()
    assert list(gap) == [0.0, 0.0]


def test_the_result_is_the_same_from_either_side(run, rng):
    pairs = random_pairs(rng, 300)
    swapped_axis = [3, 4, 5, 0, 1, 2, *(6 + 3 * j + i for i in range(3) for j in range(3))]
    overlap, gap, axis = ask(run, pairs)
    from_b, gap_from_b, axis_from_b = ask(run, [(T_b, g, T_a, h) for T_a, h, T_b, g in pairs])
    assert np.array_equal(overlap, from_b)
    assert_close(gap, gap_from_b, atol=1e-14)
    assert np.array_equal(np.take(swapped_axis, axis), axis_from_b)


def test_a_rigid_motion_of_both_changes_nothing(run, rng):
    pairs = random_pairs(rng, 300)
    overlap, gap, axis = ask(run, pairs)
    motions = [random_pose(rng, 10) for _ in pairs]
    overlap_there, gap_there, axis_there = ask(
        run, [(T @ p[0], p[1], T @ p[2], p[3]) for T, p in zip(motions, pairs, strict=True)]
    )
    assert np.array_equal(overlap, overlap_there)
    assert_close(gap, gap_there, atol=1e-13)
    assert np.array_equal(axis, axis_there)


def test_growing_both_boxes_narrows_the_gap(run, rng):
    pairs = random_pairs(rng, 300)
    _, gap, _ = ask(run, pairs)
    _, narrower, _ = ask(run, [(T_a, h + 0.01, T_b, g + 0.02) for T_a, h, T_b, g in pairs])
    assert (narrower <= gap - 0.03 + 1e-12).all()  # along a face normal by exactly 0.03, elsewhere by more


def test_flat_boxes_and_points_count_as_bodies(run, rng):
    point, plate = np.zeros(3), np.array([1.0, 1.0, 0.0])
    T = random_pose(rng, 1)
    pairs = [(I, HALF, moved(0.2, -0.9, 1.9), point), (I, HALF, moved(0.6, 0, 0), point), (T, point, T, point)]
    pairs += [
        (I, plate, formulas.transform(formulas.rotation((1, 0, 0), 1.0)), plate),
        (I, plate, moved(0, 0, 1e-3), plate),
    ]
    assert list(ask(run, pairs)[0]) == [True, False, True, True, False]
