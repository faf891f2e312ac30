import numpy as np
import pytest

from ulna.description.pose import matrix_from_quaternion
from ulna.reachability.grid import nearest_orientation, super_fibonacci


def angles_to_the_nearest(points, wxyz):
    return 2 * np.arccos(np.clip(np.abs(points @ wxyz.T).max(axis=1), 0.0, 1.0))


def random_rotations(n, seed):
    wxyz = np.random.default_rng(seed).normal(size=(n, 4))
    return wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)


@pytest.mark.parametrize("n", [1, 2, 7, 64, 5000])
def test_they_are_rotations(n):
    wxyz = super_fibonacci(n)
    assert wxyz.shape == (n, 4)
    np.testing.assert_allclose(np.linalg.norm(wxyz, axis=1), 1.0, rtol=0, atol=1e-12)


def test_they_are_those_of_the_paper():
    """Algorithm 1 of Alexa 2022, written for a single sample, x y z w."""
    n, phi, psi = 50, np.sqrt(2.0), 1.533751168755204288118041
    assert psi**4 == pytest.approx(psi + 4, abs=1e-14)
    for i in range(n):
        s = i + 0.5
        t, d = s / n, 2 * np.pi * s
        x, y = np.sqrt(t) * np.sin(d / phi), np.sqrt(t) * np.cos(d / phi)
        z, w = np.sqrt(1 - t) * np.sin(d / psi), np.sqrt(1 - t) * np.cos(d / psi)
        np.testing.assert_allclose(super_fibonacci(n)[i], [w, x, y, z], rtol=0, atol=1e-14)


def test_the_mean_rotation_is_none():
    """The integral of R over SO(3) is 0; the mean of n random rotations is about 1 / sqrt(3 n)."""
    mean = matrix_from_quaternion(super_fibonacci(4000)).mean(axis=0)
    assert np.abs(mean).max() < 0.2 / np.sqrt(3 * 4000)


@pytest.mark.parametrize("n", [64, 512])
def test_no_rotation_is_as_far_from_all_of_them_as_from_as_many_random_ones(n):
    probes = random_rotations(20_000, 1)
    even = angles_to_the_nearest(probes, super_fibonacci(n)).max()
    assert even < 0.85 * angles_to_the_nearest(probes, random_rotations(n, 2)).max()


def test_the_nearest_is_found_as_by_the_angle_of_the_relative_rotation():
    wxyz, R = super_fibonacci(40), matrix_from_quaternion(random_rotations(200, 3))
    traces = np.einsum("aij,bij->ab", R, matrix_from_quaternion(wxyz))  # 1 + 2 cos(angle)
    assert (nearest_orientation(R, wxyz) == traces.argmax(axis=1)).all()
    assert nearest_orientation(R[:0], wxyz).shape == (0,)
