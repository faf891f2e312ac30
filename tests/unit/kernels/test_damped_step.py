"""A step of damped least squares against ``numpy.linalg.solve``, and at the limits against its own words."""

import numpy as np
import pytest

import kernel_probes as probes
import naive
from close import assert_close

N = 16


def problems(rng, n_dof, damping):
    """J of shape (N, 6, n_dof), e (N, 6), and the rows that a probe loads."""
    J, e = rng.normal(size=(N, 6, n_dof)), rng.normal(size=(N, 6))
    return J, e, np.vstack([J.transpose(2, 1, 0).reshape(6 * n_dof, N), np.full(N, damping), e.T])


@pytest.mark.parametrize("n_dof", [1, 2, 5, 6, 7, 12])
@pytest.mark.parametrize("damping", [10.0, 1e-1, 1e-3])
def test_the_system_is_solved_as_numpy_solves_it(run, rng, n_dof, damping):
    J, e, rows = problems(rng, n_dof, damping)
    y = run(probes.damped_system, rows, 27, n_dof)[21:].T
    expected = [naive.damped_solution(J[k], e[k], damping) for k in range(N)]
    assert_close(
        y / np.linalg.norm(expected, axis=1)[:, None],
        expected / np.linalg.norm(expected, axis=1)[:, None],
        atol=1e-14 * (1 + 10 / damping),
    )


@pytest.mark.parametrize("damping", [1e-6, 1e-9, 1e-12])
def test_with_little_damping_a_redundant_arm_meets_the_error(run, rng, damping):
    J, e, rows = problems(rng, 9, damping)
    y = run(probes.damped_system, rows, 27, 9)[21:].T
    residual = np.einsum("nij,nkj,nk->ni", J, J, y) + damping * y - e
    assert abs(residual).max() < 1e-10


def test_at_a_singularity_damping_keeps_the_step_finite(run):
    J = np.zeros((6, 7))
    J[0] = 1.0
    e, damping = np.arange(1.0, 7.0), 1e-6
    y = run(probes.damped_system, np.concatenate([J.T.ravel(), [damping], e])[:, None], 27, 7)[21:, 0]
    assert_close(y, naive.damped_solution(J, e, damping), rtol=1e-9)
    assert_close(J.T @ y, np.full(7, 1 / (7 + damping)), rtol=1e-9)


def stepped(run, rows, q, limits, posture=None):
    """q after one step and the largest change, of columns of problems."""
    n_dof = len(q)
    goal = np.zeros(n_dof) if posture is None else posture
    out = run(probes.damped_step, np.vstack([rows, q]), 7 * n_dof + 1 + 27, limits, goal, posture is not None)
    return out[:n_dof].T, out[n_dof]


def naive_step(J, e, damping, q, limits, posture=None):
    push = J.T @ e
    pressed = ((q <= limits[0]) & (push < 0)) | ((q >= limits[1]) & (push > 0))
    J = np.where(pressed, 0.0, J)
    d = np.zeros(len(q)) if posture is None else posture - q
    d = d / max(1.0, np.abs(d).max())  # at most a radian a step
    return np.clip(q + d + J.T @ naive.damped_solution(J, e - J @ d, damping), *limits)


def test_a_step_is_the_damped_pseudo_inverse(run, rng):
    J, e, rows = problems(rng, 7, 0.05)
    q, limits = rng.normal(size=(7, N)), np.array([[-np.inf] * 7, [np.inf] * 7])
    moved, largest = stepped(run, rows, q, limits)
    expected = [naive_step(J[k], e[k], 0.05, q[:, k], limits) for k in range(N)]
    assert_close(moved, expected, atol=1e-12)
    assert_close(largest, abs(expected - q.T).max(axis=1), atol=1e-12)


def test_a_step_stays_within_the_limits_and_frees_what_presses_against_them(run, rng):
    J, e, rows = problems(rng, 7, 0.05)
    limits = np.array([np.full(7, -0.3), np.full(7, 0.4)])
    q = rng.choice([-0.3, 0.4, 0.0, 0.1, np.nextafter(-0.3, 0), np.nextafter(0.4, 0)], size=(7, N))
    moved, _ = stepped(run, rows, q, limits)
    assert_close(moved, [naive_step(J[k], e[k], 0.05, q[:, k], limits) for k in range(N)], atol=1e-12)
    assert (moved >= limits[0]).all()
    assert (moved <= limits[1]).all()


def test_a_posture_uses_the_freedom_that_the_error_leaves(run, rng):
    J, e, rows = problems(rng, 8, 1e-8)
    q, limits, posture = rng.normal(size=(8, N)), np.array([[-np.inf] * 8, [np.inf] * 8]), rng.normal(size=8)
    moved, _ = stepped(run, rows, q, limits, posture)
    assert_close(moved, [naive_step(J[k], e[k], 1e-8, q[:, k], limits, posture) for k in range(N)], atol=1e-7)
    assert_close(np.einsum("nij,nj->ni", J, moved - q.T), e, atol=1e-5)  # to first order the error is met


def test_the_length_of_a_descent_is_where_a_linear_arm_is_nearest(run, rng):
    J, e, _ = problems(rng, 7, 0.0)
    limits, q = np.array([[-np.inf] * 7, [np.inf] * 7]), np.zeros((7, N))
    rows = np.vstack([J.transpose(2, 1, 0).reshape(42, N), e.T, q])
    length = run(probes.length_of_step, rows, 43, limits)[42]
    for k in range(N):
        v = J[k] @ J[k].T @ e[k]
        assert abs((e[k] - length[k] * v) @ v) < 1e-9 * (v @ v)  # what is left is square to what was moved
        left = [np.linalg.norm(e[k] - s * length[k] * v) for s in (0.99, 1, 1.01)]
        assert left[1] == min(left)


def test_without_an_error_there_is_no_length(run, rng):
    rows = np.vstack([rng.normal(size=(42, 3)), np.zeros((6, 3)), np.zeros((7, 3))])
    assert not run(probes.length_of_step, rows, 43, np.array([[-1.0] * 7, [1.0] * 7]))[42].any()


def test_columns_that_press_against_a_limit_are_released(run, rng):
    J, e, _ = problems(rng, 7, 0.0)
    limits = np.array([np.full(7, -1.0), np.full(7, 1.0)])
    q = rng.choice([-1.0, 0.0, 1.0], size=(7, N))
    rows = np.vstack([J.transpose(2, 1, 0).reshape(42, N), e.T, q])
    left = run(probes.length_of_step, rows, 43, limits)[:42].T.reshape(N, 7, 6)
    push = np.einsum("nij,ni->nj", J, e)
    pressed = ((q.T == -1) & (push < 0)) | ((q.T == 1) & (push > 0))
    assert pressed.any()
    assert np.array_equal(left, np.where(pressed[..., None], 0.0, J.transpose(0, 2, 1)))
