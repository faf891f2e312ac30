"""Pairs of every kind against Coal. Where the two differ by more than 1e-6 m it is Coal that errs: Ulna's answer proves itself.

For bodies apart points and a separating plane as far apart as each other leave no other answer. Where they overlap, a way out
along a normal is as short as the shadows along it say, and Coal claims a longer one. The cases are few: Coal's closed form for a
sphere whose center is within a cylinder does not ask every face, and its search in a cylinder sometimes ends early (or fails,
and answers -1.8e308).
"""

from functools import partial

import numpy as np
import pytest

import kernel_modes
import solids
from assertions import assert_close
from coal_pairs import coal_distances, coal_scene

CONTACT = 1e-8  # [m] nearer to touching than this, either verdict is right
# How many of 2000 pairs with a cylinder Coal may get wrong before this test looks wrong itself.
COALS_ERRORS = 100

run = partial(kernel_modes.run, "f64x8")


@pytest.mark.slow
@pytest.mark.parametrize("kinds", solids.PAIRS, ids="-".join)
def test_distances_and_verdicts_are_coals_or_coal_is_wrong(rng, kinds):
    pairs = solids.random_pairs(rng, kinds, 2000, 0.35)
    d, *_, overlap = answer = solids.ask(run, pairs)
    expected = coal_distances(coal_scene(pairs), 1e-8 if "cylinder" in kinds else 1e-12)
    assert 0.1 < overlap.mean() < 0.9
    sure = np.abs(expected) > CONTACT
    assert np.array_equal(overlap[sure], expected[sure] < 0)
    differ = np.flatnonzero(np.abs(d - expected) > 1e-6)
    assert len(differ) <= (COALS_ERRORS if "cylinder" in kinds else 0)
    assert (d[differ] < 0).all()
    assert (expected[differ] < d[differ]).all()
    solids.assert_proved([pairs[k] for k in differ], [part[differ] for part in answer], 2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", solids.KINDS)
def test_a_half_space_is_as_far_as_coal_says(rng, kind):
    import ulna

    floor = ulna.HalfSpace()
    pairs = [(a, T_a, floor, solids.random_pose(rng, 0.5)) for a, T_a, _, _ in solids.random_pairs(rng, (kind, kind), 1000, 0.5)]
    d, *_ = solids.ask(run, pairs)
    assert_close(d, coal_distances(coal_scene(pairs), 1e-12), atol=1e-9)


@pytest.mark.slow
def test_a_hundred_thousand_pairs_of_boxes(rng):
    pairs = solids.random_pairs(rng, ("box", "box"), 100_000, 0.6)
    d, p, q, n, overlap = solids.ask(run, pairs)
    expected = coal_distances(coal_scene(pairs), 1e-12)
    assert 0.2 < overlap.mean() < 0.8
    sure = np.abs(expected) > CONTACT
    assert np.array_equal(overlap[sure], expected[sure] < 0)
    assert_close(d, expected, atol=1e-6)
    assert_close(q - p, d[:, None] * n, atol=1e-12)
    solids.assert_proved(pairs[:2000], [part[:2000] for part in (d, p, q, n, overlap)])
