"""The rotation vector of a matrix, judged by Rodrigues' formula: near zero, near pi on both sides, and at pi exactly."""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
from assertions import assert_close
from robots import unit

AXES = [
    *np.eye(3),
    *-np.eye(3),
    unit(1, 1, 0),
    unit(0, 1, -1),
    unit(-1, 0, 1),
    unit(1, 1, 1),
    unit(-1, -2, 3),
    unit(1e-4, 1, 1e-9),
]
TINY = [0.0, 1e-300, 1e-160, 1e-150, 1e-149, 1e-100, 1e-20, 1e-16, 1e-12, 1e-8, 1e-7, 1e-4, 1e-2]
NEAR_PI = [1e-15, 1e-12, 1e-9, 1e-8, 1e-6, 1e-3, 0.1]


def vectors_of(run, rotations):
    return run(probes.vector_of_rotation, np.reshape(rotations, (len(rotations), 9)).T, 3).T


def poses(rotations):
    """Inputs of pose kernels: twelve numbers each, any position."""
    return np.array([np.column_stack([R, (0.5, -2.0, 3.0)]).ravel() for R in rotations]).T


def random_rotations(rng, n):
    return [formulas.rotation(rng.normal(size=3), rng.uniform(-np.pi, np.pi)) for _ in range(n)]


@pytest.mark.parametrize("angle", TINY)
def test_small_rotations_keep_their_relative_accuracy(run, angle):
    found = vectors_of(run, [formulas.rotation(axis, angle) for axis in AXES])
    assert_close(found, np.array(AXES) * angle, rtol=4e-15, atol=angle * 2e-16)


@pytest.mark.parametrize("short", NEAR_PI)
def test_below_pi_the_axis_keeps_its_sign(run, short):
    found = vectors_of(run, [formulas.rotation(axis, np.pi - short) for axis in AXES])
    assert_close(found, np.array(AXES) * (np.pi - short), atol=2e-15)


@pytest.mark.parametrize("beyond", NEAR_PI)
def test_beyond_pi_it_turns_the_other_way_round(run, beyond):
    found = vectors_of(run, [formulas.rotation(axis, np.pi + beyond) for axis in AXES])
    assert_close(found, np.array(AXES) * (beyond - np.pi), atol=2e-15)


def test_at_pi_exactly_either_sign_is_right(run):
    half_turns = [2 * np.outer(axis, axis) - np.eye(3) for axis in AXES]
    found = vectors_of(run, half_turns)
    for vector, axis in zip(found, AXES, strict=True):
        assert_close(np.outer(vector, vector), np.pi**2 * np.outer(axis, axis), atol=1e-14)


@pytest.mark.parametrize("axis", AXES)
def test_every_angle_comes_back_where_the_branches_meet(run, axis):
    borders = np.array([2 * np.pi / 3, np.pi / 2, np.pi / 4, np.pi / 8])  # where the largest of w, x, y, z changes
    angles = np.concatenate([borders * (1 + d) for d in (-1e-6, -1e-15, 0, 1e-15, 1e-6)] + [np.linspace(0.01, 3.1, 60)])
    found = vectors_of(run, [formulas.rotation(axis, angle) for angle in angles])
    assert_close(found, np.outer(angles, axis), atol=2e-15)


def test_random_rotations_match_the_eigen_decomposition(run, rng):
    rotations = [formulas.rotation(rng.normal(size=3), rng.uniform(0, 3)) for _ in range(200)]
    assert_close(vectors_of(run, rotations), [formulas.logarithm(R) for R in rotations], atol=1e-13)


def test_turning_by_the_vector_gives_the_matrix_back(run, rng):
    rotations = random_rotations(rng, 300)
    for R, vector in zip(rotations, vectors_of(run, rotations), strict=True):
        angle = np.linalg.norm(vector)
        assert angle <= np.pi + 1e-15
        assert_close(formulas.rotation(vector, angle), R, atol=2e-15)


def test_the_inverse_has_the_opposite_vector(run, rng):
    rotations = np.array(random_rotations(rng, 200))
    assert_close(vectors_of(run, rotations), -vectors_of(run, rotations.transpose(0, 2, 1)), atol=2e-15)


def test_a_change_of_axes_turns_the_vector(run, rng):
    rotations, changes = np.array(random_rotations(rng, 200)), np.array(random_rotations(rng, 200))
    seen = changes @ rotations @ changes.transpose(0, 2, 1)
    expected = np.einsum("nij,nj->ni", changes, vectors_of(run, rotations))
    assert_close(vectors_of(run, seen), expected, atol=2e-14)


def test_the_vector_between_two_poses_leads_from_one_to_the_other(run, rng):
    a, b = random_rotations(rng, 200), random_rotations(rng, 200)
    found = run(probes.vector_between, np.vstack([poses(a), poses(b)]), 3).T
    for R_a, R_b, vector in zip(a, b, found, strict=True):
        assert_close(formulas.rotation(vector, np.linalg.norm(vector)) @ R_a, R_b, atol=3e-15)


def test_nothing_lies_between_a_pose_and_itself(run, rng):
    a = poses(random_rotations(rng, 100))
    assert abs(run(probes.vector_between, np.vstack([a, a]), 3)).max() < 1e-15


def test_what_is_no_number_gives_no_number(run):
    R = np.full((1, 3, 3), np.nan)
    assert np.isnan(vectors_of(run, R)).all()
