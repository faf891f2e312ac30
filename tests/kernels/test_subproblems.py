"""The subproblems of closed forms: an angle solves its equation, or no angle of a fine grid is better; and the arc tangent."""

import numpy as np
import pytest

import closed_form_probes as probes
import formulas

N = 60
GRID = np.linspace(-np.pi, np.pi, 2001)


@pytest.fixture
def rng():
    return np.random.default_rng(12)


def units(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def turned(k, angle, p):
    return formulas.rotation(k, angle) @ p


def angles(found):
    np.testing.assert_allclose(found[0] ** 2 + found[1] ** 2, 1.0, atol=1e-14)
    return np.arctan2(found[0], found[1])


# ---- one vector onto another


def test_the_angle_onto_a_vector_is_that_by_which_it_was_turned(run, rng):
    k, p, angle = units(rng, N), rng.normal(size=(N, 3)), rng.uniform(-np.pi, np.pi, N)
    q = np.array([turned(*row) for row in zip(k, angle, p, strict=True)])
    found = angles(run(probes.onto, np.hstack([p, q, k]).T, 3))
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * angle), atol=1e-14)


@pytest.mark.slow
def test_no_angle_leads_nearer_to_a_vector_off_the_circle(run, rng):
    k, p, q = units(rng, N), rng.normal(size=(N, 3)), rng.normal(size=(N, 3))
    found = angles(run(probes.onto, np.hstack([p, q, k]).T, 3))
    for row in range(N):
        missed = [np.linalg.norm(turned(k[row], x, p[row]) - q[row]) for x in (found[row], *GRID)]
        assert missed[0] <= min(missed[1:]) + 1e-14


@pytest.mark.parametrize("near", [1e-2, 1e-5, 1e-8, 1e-10])
def test_near_the_axis_the_angle_keeps_what_digits_the_vectors_have(run, rng, near):
    """Vectors of length 1, ``near`` from an axis: they have 16 digits, so the angle has those less the digits of ``near``."""
    k, angle = units(rng, N), rng.uniform(-np.pi, np.pi, N)
    across = np.cross(k, units(rng, N))
    across /= np.linalg.norm(across, axis=1)[:, None]
    p = k + near * across
    q = np.array([k_ + near * turned(k_, x, v) for k_, x, v in zip(k, angle, across, strict=True)])
    found = angles(run(probes.onto, np.hstack([p, q, k]).T, 3))
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * angle), atol=2e-15 / near)


def test_on_the_axis_the_free_angle_is_taken(run, rng):
    k = units(rng, N)
    found = run(probes.onto, np.hstack([k, 1.7 * k, k]).T, 3)
    np.testing.assert_array_equal(found[:2].T, np.tile(probes.FREE, (N, 1)))


# ---- onto a plane, a sphere, a direction


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_vector_is_turned_into_the_plane_and_the_two_angles_are_all(run, rng, sign):
    h, p, k, angle = units(rng, N), rng.normal(size=(N, 3)), units(rng, N), rng.uniform(-np.pi, np.pi, N)
    d = np.array([h_ @ turned(k_, x, p_) for h_, k_, x, p_ in zip(h, k, angle, p, strict=True)])
    both = []
    for s in (sign, -sign):
        found = angles(run(probes.to_plane, np.column_stack([h, p, k, d, np.full(N, s)]).T, 4))
        reached = [h_ @ turned(k_, x, p_) for h_, k_, x, p_ in zip(h, k, found, p, strict=True)]
        np.testing.assert_allclose(reached, d, atol=2e-14)
        both.append(np.exp(1j * found))
    assert np.minimum(*np.abs(np.array(both) - np.exp(1j * angle))).max() < 1e-6


@pytest.mark.parametrize("excess", [1e-9, 1e-3, 0.5])
def test_beyond_the_plane_no_angle_is_better(run, rng, excess):
    h, p, k = units(rng, N), rng.normal(size=(N, 3)), units(rng, N)
    along = (h * k).sum(axis=1) * (k * p).sum(axis=1)
    most = np.linalg.norm(np.cross(k, h), axis=1) * np.linalg.norm(np.cross(k, p), axis=1)
    for side in (1.0, -1.0):
        d = along + side * (most + excess)
        found = run(probes.to_plane, np.column_stack([h, p, k, d, np.ones(N)]).T, 4)
        assert (found[3] < 0.0).all()
        reached = np.array([h_ @ turned(k_, x, p_) for h_, k_, x, p_ in zip(h, k, angles(found), p, strict=True)])
        np.testing.assert_allclose(np.abs(reached - d), excess, atol=1e-13)


def test_a_vector_is_turned_to_its_distance_from_another(run, rng):
    p, q, k, angle = rng.normal(size=(N, 3)), rng.normal(size=(N, 3)), units(rng, N), rng.uniform(-np.pi, np.pi, N)
    square = np.array([((turned(k_, x, p_) - q_) ** 2).sum() for k_, x, p_, q_ in zip(k, angle, p, q, strict=True)])
    for sign in (1.0, -1.0):
        found = angles(run(probes.to_sphere, np.column_stack([p, q, k, square, np.full(N, sign)]).T, 4))
        reached = [((turned(k_, x, p_) - q_) ** 2).sum() for k_, x, p_, q_ in zip(k, found, p, q, strict=True)]
        np.testing.assert_allclose(reached, square, rtol=0, atol=1e-13)


@pytest.mark.parametrize("bend", [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_near_the_singularity_of_a_wrist_its_bend_keeps_its_digits(run, rng, bend):
    """Axes 4 and 6 parallel at zero and normal to axis 5: h and v make the angle that is looked for. A cosine would lose 1e-8."""
    h, k = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    turns = rng.uniform(-np.pi, np.pi, N)
    v = np.array([turned(h, x, turned(k, bend, h)) for x in turns])
    in_frame = v[:, [1, 2, 0]]  # of h: along y, z and h
    inputs = np.column_stack([np.tile([*h, *h, *k], (N, 1)), in_frame, np.zeros((N, 2)), np.ones(N)])
    found = angles(run(probes.to_direction, inputs.T, 4))
    np.testing.assert_allclose(np.abs(found), bend, rtol=0, atol=4e-16 + 2e-16 * bend)


def test_the_angle_of_a_sine_and_a_cosine_keeps_their_digits(run, rng):
    """These are rounded: where the sum of their squares is off by as much as they are, so is the angle."""
    angle = np.concatenate([rng.uniform(-np.pi, np.pi, 400), np.arange(-8, 9) * np.pi / 8 * (1 - 1e-15), [1e-300, -1e-9, 1e-9]])
    s, c = np.sin(angle), np.cos(angle)
    np.testing.assert_allclose(run(probes.arc_tangent, np.array([s, c]), 1)[0], np.arctan2(s, c), rtol=6e-16, atol=0)
