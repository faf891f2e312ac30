"""Where pairs of bodies are awkward: nothing to them, nothing between them, parallel, concentric, huge beside tiny."""

import itertools

import numpy as np
import pytest

import formulas
import solids
import ulna
from assertions import assert_close
from solids import FLAT, ask, assert_proved

I = np.eye(4)  # noqa: E741
Z = np.array([0.0, 0.0, 1.0])


def at(*xyz):
    return formulas.transform(p=xyz)


def proved(run, *pair, exactness=1e-9):
    answer = ask(run, [pair])
    assert_proved([pair], answer, exactness)
    return answer[0][0]


@pytest.mark.parametrize("kinds", solids.MATRIX, ids="-".join)
def test_points_are_bodies(run, kinds):
    a, b = (solids.POINTS[kind] for kind in kinds)
    d, p, q, n, overlap = ask(run, [(a, at(1, 2, 3), b, at(1, 2 + side * 0.5, 3)) for side in (1, -1)])
    assert_close(d, 0.5, atol=1e-15)
    assert_close(p, [(1, 2, 3)] * 2, atol=1e-15)
    assert_close(q, [(1, 2.5, 3), (1, 1.5, 3)], atol=1e-15)
    assert_close(n, [(0, 1, 0), (0, -1, 0)], atol=1e-15)
    assert not overlap.any()


@pytest.mark.parametrize("kinds", solids.MATRIX, ids="-".join)
def test_at_one_place_points_touch(run, kinds):
    d, p, q, n, overlap = ask(run, [(solids.POINTS[kinds[0]], at(1, 2, 3), solids.POINTS[kinds[1]], at(1, 2, 3))])
    assert overlap.all()
    assert_close(d, 0, atol=1e-12)
    assert_close(p, q, atol=1e-12)
    assert_close(np.linalg.norm(n), 1, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kinds", [pair for pair in solids.PAIRS if "hull" not in pair], ids="-".join)
def test_flat_bodies_have_contacts_with_proofs(run, rng, kinds):
    a, b = (FLAT[kind] for kind in kinds)
    pairs = [(a, solids.random_pose(rng, 0.2), b, solids.random_pose(rng, 0.2)) for _ in range(20)]
    assert_proved(pairs, ask(run, pairs), 1e-8 if solids.exactness(kinds) > solids.OF_POLYTOPES else 1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("kind", solids.KINDS)
def test_a_flat_hull_has_a_distance(run, rng, kind):
    pairs = [(solids.random_solid(rng, "hull"), solids.random_pose(rng, 0.1), FLAT["hull"], at(0, 0, 2))] if kind == "hull" else [
        (solids.random_solid(rng, kind), solids.random_pose(rng, 0.1), FLAT["hull"], at(0, 0, 2)) for _ in range(10)]  # fmt: skip
    for pair, d, n in zip(pairs, *(ask(run, pairs)[k] for k in (0, 3)), strict=True):
        assert_close(solids.gap_along(*pair, n), d, atol=1e-9)


@pytest.mark.parametrize("kinds", solids.MATRIX, ids="-".join)
def test_what_is_no_number_has_no_distance(run, rng, kinds):
    pairs = solids.random_pairs(rng, kinds, 9)
    for T in (pairs[3][1], pairs[5][3]):
        T[1, 3] = np.nan
    assert np.flatnonzero(np.isnan(ask(run, pairs)[0])).tolist() == [3, 5]


@pytest.mark.parametrize("kinds", [("box", "box"), ("box", "cylinder"), ("cylinder", "cylinder"), ("box", "hull")], ids="-".join)
@pytest.mark.parametrize("gap", [0.1, 1e-3, 1e-6, -1e-6, -1e-3])
def test_parallel_faces_keep_their_gap(run, kinds, gap):
    """Stacked upon each other, turned about the vertical, at many places: every one a tie of faces, edges and corners."""
    low = {"box": ulna.Box((1, 0.8, 0.4)), "cylinder": ulna.Cylinder(radius=0.5, length=0.4)}[kinds[0]]
    high = {"box": ulna.Box((0.7, 0.9, 0.6)), "cylinder": ulna.Cylinder(radius=0.4, length=0.6),
            "hull": ulna.ConvexMesh(list(itertools.product((-0.3, 0.4), (-0.5, 0.2), (-0.3, 0.3))))}[kinds[1]]  # fmt: skip
    pairs = [(low, I, high, formulas.transform(formulas.rotation(Z, angle), (x, y, 0.5 + gap)))
             for angle in (0, 0.3, np.pi / 4, np.pi / 2) for x in (0, 0.3) for y in (0, -0.25)]  # fmt: skip
    answer = ask(run, pairs)
    assert_proved(pairs, answer, 1e-8)
    assert_close(answer[0], gap, atol=1e-9)
    assert_close(answer[3], [Z] * len(pairs), atol=1e-5)


@pytest.mark.parametrize("tilt", [0, 1e-16, 1e-13, 6e-13, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3])
def test_crossed_boards_meet_where_no_corner_lies(run, rng, tilt):
    """Two boards that cross like a plus sign: no corner of one is over the other, and only edges that cross can tell."""
    board = ulna.Box((4, 1, 0.2))
    for _ in range(10):
        R = formulas.rotation(rng.normal(size=3), tilt) @ formulas.rotation(Z, np.pi / 2 + rng.uniform(-0.3, 0.3))
        pair = board, solids.random_pose(rng), board, formulas.transform(R, (0.2, 0.1, 0.7))
        pair = (*pair[:3], pair[1] @ pair[3])
        assert_close(proved(run, *pair, exactness=1e-11), 0.5, atol=4 * tilt + 1e-11)


@pytest.mark.parametrize("kinds", solids.MATRIX, ids="-".join)
def test_equal_poses_have_a_depth(run, rng, kinds):
    a, b = (solids.random_solid(rng, kind) for kind in kinds)
    T = solids.random_pose(rng)
    d = proved(run, a, T, b, T, exactness=1e-7 if "cylinder" in kinds else 1e-9)
    assert d < 0
    assert solids.widest_gap_found(a, T, b, T, rng, 4) <= d + 1e-7


@pytest.mark.parametrize("kinds", solids.MATRIX, ids="-".join)
@pytest.mark.parametrize("small", [1e-3, 1e-9])
def test_a_crumb_within_a_large_body_is_met(run, rng, kinds, small):
    """The checkers that compare surfaces miss a body that lies wholly inside another."""
    large, crumb = solids.random_solid(rng, kinds[0], 1e2), solids.random_solid(rng, kinds[1], small)
    middle = large.vertices.mean(axis=0) if kinds[0] == "hull" else np.array([1e-3, 0, 0])
    assert proved(run, large, I, crumb, at(*middle), exactness=1e-6) < -1


@pytest.mark.parametrize("kinds", solids.MATRIX, ids="-".join)
def test_a_crumb_beside_a_huge_body_has_its_distance(run, rng, kinds):
    huge, crumb = solids.random_solid(rng, kinds[0], 1e4), solids.random_solid(rng, kinds[1], 1e-6)
    T = solids.random_pose(rng, 1.0)
    T[:3, 3] = 2e4
    d = proved(run, huge, I, crumb, T, exactness=1e-6)
    assert d > 1e3
