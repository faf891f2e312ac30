"""Boxes whose edges are nearly parallel: there the product of two edges says little, and must not lie.

Two bars, each turned about its own long edge by 45 degrees so that an edge is on top, are laid across each other at an angle.
The lower bar's top edge and the upper bar's bottom edge then are the only parts that can touch, however small the angle, and
their distance is known.
"""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
from assertions import assert_close

ANGLES = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9, 1e-10, 1e-12, 1e-14, 1e-15, 1e-16, 0.0]
GAPS = [1e-1, 1e-3, 1e-5, 1e-6, 1e-7]
BAR = np.array([1.0, 0.1, 0.1])
X, Y, Z = np.eye(3)
ON_EDGE = formulas.transform(formulas.rotation(X, np.pi / 4))


def ask(run, pairs):
    rows = [[*T_a[:3].ravel(), *h, *T_b[:3].ravel(), *g] for T_a, h, T_b, g in pairs]
    overlap, gap, axis = run(probes.two_boxes, np.transpose(rows), 3)
    return overlap == 1.0, gap, axis.astype(int)


def bars(angle, gap):
    """Two bars that lie edge over edge, ``gap`` apart, crossing at ``angle``."""
    above = formulas.transform(formulas.rotation(Z, angle), (0, 0, 2 * np.sqrt(2) * BAR[1] + gap))
    return ON_EDGE, BAR, above @ ON_EDGE, BAR


@pytest.mark.parametrize("gap", [*GAPS, *(-g for g in GAPS)])
def test_crossed_bars_are_apart_exactly_if_their_edges_are(run, gap):
    overlap, widest, _ = ask(run, [bars(angle, gap) for angle in ANGLES])
    assert list(overlap) == [gap < 0] * len(ANGLES)
    assert ((widest > 0) == (gap > 0)).all()


@pytest.mark.parametrize("gap", GAPS)
def test_the_gap_of_crossed_bars_is_a_bound_of_their_distance(run, gap):
    """Edges over each other are ``gap`` apart; where they give no axis, the faces at 45 degrees still show gap / sqrt(2)."""
    _, widest, axis = ask(run, [bars(angle, gap) for angle in ANGLES])
    assert (widest <= gap + 2e-8).all()
    assert (widest >= gap / np.sqrt(2) - 2e-8).all()
    crossed = np.array(ANGLES) >= 1e-7
    assert_close(widest[crossed], gap, atol=2e-8)
    assert (axis[crossed] == 6).all()


@pytest.mark.parametrize("place", [(0, 0, 0), (3.0, -2.0, 5.0), (-40.0, 10.0, 0.3)])
def test_where_the_bars_lie_does_not_matter(run, rng, place):
    T = formulas.transform(formulas.rotation(rng.normal(size=3), 2.0), place)
    pairs = [(gap, bars(angle, gap)) for angle in ANGLES for gap in (1e-6, -1e-6, 1e-3, -1e-3)]
    overlap, _, _ = ask(run, [(T @ T_a, h, T @ T_b, g) for _, (T_a, h, T_b, g) in pairs])
    assert list(overlap) == [gap < 0 for gap, _ in pairs]


@pytest.mark.slow
@pytest.mark.parametrize("turn_axis", [X, Y, Z, np.array([0.6, -0.8, 0.0]), np.array([0.48, 0.64, 0.6])])
@pytest.mark.parametrize("across", [X, Y, Z])
def test_stacked_boxes_barely_turned_keep_their_gap(run, across, turn_axis):
    """Face to face, one turned by a small angle: compared with the corners' shadows where the angle still gives axes."""
    h, g = np.array([0.3, 0.4, 0.5]), np.array([0.2, 0.35, 0.45])
    pairs, expected = [], []
    for angle in ANGLES[3:]:
        for gap in (1e-3, 1e-6, -1e-6, -1e-3):
            T_b = formulas.transform(formulas.rotation(turn_axis, angle), across * ((h + g) @ across))
            T_b[:3, 3] += across * (gap - formulas.gaps_of_boxes(np.eye(4), h, T_b, g)[:6].max())
            pairs.append((np.eye(4), h, T_b, g))
            expected.append(formulas.gaps_of_boxes(*pairs[-1]).max())
    overlap, widest, _ = ask(run, pairs)
    assert_close(widest, expected, atol=2e-8)
    assert np.array_equal(overlap, np.array(expected) <= 0)


def test_parallel_boxes_have_no_gap_along_a_product_of_edges(run, rng):
    """Equal orientations up to rounding, deep inside each other: the noise of nine null products must not part them."""
    pairs, angles = [], 10.0 ** rng.uniform(-17, -7, 200)
    for angle in angles:
        R = formulas.rotation(rng.normal(size=3), rng.uniform(-3, 3))
        noise = formulas.rotation(rng.normal(size=3), angle)
        p = rng.normal(size=3)
        pairs.append(
            (
                formulas.transform(R, p),
                BAR,
                formulas.transform(R @ noise, p + R @ (BAR * rng.uniform(-1.9, 1.9, 3))),
                BAR,
            )
        )
    overlap, widest, axis = ask(run, pairs)
    assert overlap.all()
    assert (widest < 0).all()
    gaps = np.array([formulas.gaps_of_boxes(*pair)[:6].max() for pair in pairs])
    assert_close(widest, gaps, atol=2e-8)
    assert not set(axis[angles < 5e-9]) & {6, 10, 14}  # the product of an edge with itself
