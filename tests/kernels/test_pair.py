"""Two bodies of every kind. An answer proves itself: its points lie on the shapes, as far apart as it says, along its normal; and
along that normal the shadows of the shapes leave just that gap, so that apart no other points can be nearer, and overlapping
this way out is as long as it says. That no way out is shorter is then asked of many other directions.
"""

import numpy as np
import pytest

import formulas
import solids
import ulna
from assertions import assert_close
from solids import ask, assert_proved, random_pairs

N = 32


@pytest.fixture(params=solids.MATRIX, ids="-".join)
def kinds(request):
    return request.param


def test_every_result_proves_itself(run, rng, kinds):
    pairs = random_pairs(rng, kinds, N)
    answer = ask(run, pairs)
    assert 0.1 < answer[4].mean() < 0.9
    assert_proved(pairs, answer, solids.exactness(kinds))


@pytest.mark.slow
def test_no_translation_that_separates_is_shorter(run, rng, kinds):
    pairs = random_pairs(rng, kinds, 12, 0.2)
    for pair, d in zip(pairs, ask(run, pairs)[0], strict=True):
        assert solids.widest_gap_found(*pair, rng, 4) <= d + 2e-9


def test_from_the_other_side_it_is_the_same(run, rng, kinds):
    pairs = random_pairs(rng, kinds, N)
    d, _, _, n, _ = ask(run, pairs)
    d_swapped, p, q, n_swapped, _ = answer = ask(run, [(b, T_b, a, T_a) for a, T_a, b, T_b in pairs])
    rounded = solids.exactness(kinds) > solids.OF_POLYTOPES
    assert_close(d_swapped, d, atol=2e-9 if rounded else 1e-12)
    assert_close(n_swapped[d > 1e-6], -n[d > 1e-6], atol=1e-4 if rounded else 1e-9)
    assert_close(q - p, d_swapped[:, None] * n_swapped, atol=1e-12)
    assert answer[4].tolist() == (d <= 0).tolist()


def test_a_rigid_motion_of_both_moves_the_result(run, rng, kinds):
    pairs, T = random_pairs(rng, kinds, N), solids.random_pose(rng, 10)
    d, p, _, n, _ = ask(run, pairs)
    d_moved, p_moved, _, n_moved, _ = ask(run, [(a, T @ T_a, b, T @ T_b) for a, T_a, b, T_b in pairs])
    exactness = solids.exactness(kinds)
    apart = d > 1e-6
    assert_close(d_moved, d, atol=exactness)
    assert_close(n_moved[apart], n[apart] @ T[:3, :3].T, atol=1e4 * exactness)
    assert_close(p_moved[apart], p[apart] @ T[:3, :3].T + T[:3, 3], atol=1e4 * exactness)


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_a_larger_scene_has_larger_distances(run, rng, scale):
    for kinds in solids.PAIRS:
        pairs = random_pairs(rng, kinds, 8)
        scaled = [
            (solids.scaled_by(a, scale), stretched(T_a, scale), solids.scaled_by(b, scale), stretched(T_b, scale))
            for a, T_a, b, T_b in pairs
        ]
        assert_close(ask(run, scaled)[0] / scale, ask(run, pairs)[0], atol=solids.exactness(kinds))


def stretched(T, s):
    return formulas.transform(T[:3, :3], s * T[:3, 3])


@pytest.mark.parametrize("kind", solids.KINDS)
def test_a_floor_touches_the_lowest_point(run, rng, kind):
    shape, floor = solids.random_solid(rng, kind), ulna.HalfSpace()
    poses = [(solids.random_pose(rng, 0.5), solids.random_pose(rng, 0.5)) for _ in range(N)]
    for floor_first in (False, True):
        pairs = [(floor, T_floor, shape, T) if floor_first else (shape, T, floor, T_floor) for T, T_floor in poses]
        d, p, q, n, overlap = ask(run, pairs)
        if floor_first:
            p, q, n = q, p, -n
        for k, (T, T_floor) in enumerate(poses):
            up = T_floor[:3, 2]
            assert_close(d[k], (solids.farthest(shape, T, -up) - T_floor[:3, 3]) @ up, atol=1e-12)
            assert_close(n[k], -up, atol=1e-15)
            assert abs(solids.outside(floor, T_floor, q[k])) < 1e-12
            assert solids.outside(shape, T, p[k]) < 1e-12
            assert_close(q[k] - p[k], d[k] * n[k], atol=1e-12)
            assert overlap[k] == (d[k] <= 0)


def test_two_half_spaces_have_no_distance(run, rng):
    d, *_ = ask(run, [(ulna.HalfSpace(), np.eye(4), ulna.HalfSpace(), solids.random_pose(rng))] * 3)
    assert np.isnan(d).all()
