"""The steps of steepest descent and of the pseudo-inverse, judged by NumPy's own linear algebra."""

import numpy as np
import pytest

import kernel_probes as probes
from assertions import assert_close
from ulna.kernels.ik.textbook import CUTOFF

N = 16


def steps(run, J, e):
    """Steps of the transpose and of the pseudo-inverse, (n, n_dof) each, for J (n, 6, n_dof) and e (n, 6)."""
    n, _, n_dof = J.shape
    out = run(probes.textbook_steps, np.vstack([J.transpose(2, 1, 0).reshape(6 * n_dof, n), e.T]), 8 * n_dof + 6, n_dof)
    return out[:n_dof].T, out[n_dof : 2 * n_dof].T


def with_singular_values(rng, values, n_dof):
    """N random matrices (6, n_dof) of these singular values, as many as they have."""
    turns = np.linalg.qr(rng.normal(size=(N, 6, 6)))[0], np.linalg.qr(rng.normal(size=(N, n_dof, n_dof)))[0]
    rank = len(values)
    return turns[0][:, :, :rank] * np.array(values) @ turns[1][:, :rank]


def test_the_length_of_a_descent_is_where_a_linear_arm_is_nearest(run, rng):
    J, e = rng.normal(size=(N, 6, 7)), rng.normal(size=(N, 6))
    descent, _ = steps(run, J, e)
    for k in range(N):
        g = J[k].T @ e[k]
        length = (descent[k] @ g) / (g @ g)
        assert_close(descent[k], length * g, atol=1e-12)
        left = e[k] - J[k] @ descent[k]
        assert abs(left @ (J[k] @ g)) < 1e-9 * (g @ g)  # what is left is square to what was moved
        assert length > 0


def test_without_an_error_there_is_no_step(run, rng):
    for step in steps(run, rng.normal(size=(3, 6, 7)), np.zeros((3, 6))):
        assert not step.any()


def test_without_a_column_there_is_no_step(run, rng):
    for step in steps(run, np.zeros((3, 6, 7)), rng.normal(size=(3, 6))):
        assert not step.any()


@pytest.mark.parametrize("n_dof", [1, 2, 3, 5, 6, 7, 12, 20])
def test_the_pseudo_inverse_is_numpys(run, rng, n_dof):
    J, e = rng.normal(size=(N, 6, n_dof)), rng.normal(size=(N, 6))
    _, step = steps(run, J, e)
    expected = np.array([np.linalg.pinv(J[k], rcond=CUTOFF) @ e[k] for k in range(N)])
    assert_close(step, expected, atol=1e-11 * abs(expected).max())


@pytest.mark.parametrize(
    "values",
    [
        (3.0,),
        (2.0, 2.0, 2.0),
        (1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
        (3.0, 2.0, 1.0, 0.5, 0.1),
        (1.0, 0.5, 0.2, 0.1, 0.01, 2 * CUTOFF),
        (1.0, 0.5, 0.2, 0.1, 0.01, 0.5 * CUTOFF),
        (1.0, 1.0, 0.1, 1e-6, 1e-9, 1e-13),
        (1e-3, 1e-4, 1e-5, 1e-6, 2e-7, 5e-8),
        (1e5, 1e3, 50.0, 8.0, 1.0, 1e-2),
    ],
    ids=str,
)
@pytest.mark.parametrize("n_dof", [6, 9])
def test_singular_values_are_dropped_below_the_cutoff_and_only_there(run, rng, values, n_dof):
    J, e = with_singular_values(rng, values, n_dof), rng.normal(size=(N, 6))
    _, step = steps(run, J, e)
    expected = np.array([np.linalg.pinv(J[k], rcond=CUTOFF) @ e[k] for k in range(N)])
    assert_close(step, expected, atol=1e-7 * abs(expected).max())


def test_joints_that_are_locked_are_left_alone(run, rng):
    J, e = rng.normal(size=(N, 6, 8)), rng.normal(size=(N, 6))
    J[:, :, [1, 4, 7]] = 0.0
    descent, step = steps(run, J, e)
    assert not step[:, [1, 4, 7]].any()
    assert not descent[:, [1, 4, 7]].any()
    assert_close(step, [np.linalg.pinv(J[k], rcond=CUTOFF) @ e[k] for k in range(N)], atol=1e-9)
