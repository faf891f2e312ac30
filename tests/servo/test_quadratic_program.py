"""The quadratic program of a tick: its solutions keep the rows and have multipliers that prove them the minimum."""

import numpy as np
import pytest

from ulna.kernels.servo.objective import Program
from ulna.kernels.servo.quadratic_program import minimize, solve_on_rows


def program_of(G, b):
    n = G.shape[1]
    return Program(np.zeros(0), G.ravel().copy(), b, np.zeros(n, dtype=np.int64), np.zeros(n), np.zeros(2 * n * (n + 1)))


def solved(H, f, G, b, x):
    """The minimum, and a multiplier for each row, by the kernel."""
    m, x, program = len(G), x.copy(), program_of(G, b)
    k = minimize(H.ravel().copy(), f.copy(), program, m, x)
    of_rows = np.zeros(m)
    of_rows[program.active_rows[:k]] = program.multiplier_rows[:k]
    return x, of_rows


def problem(rng, n, m, condition):
    """A convex problem, and a point that keeps its rows; some rows are active there."""
    A = rng.normal(size=(n, n)) * np.geomspace(1, condition, n)
    x, G = rng.normal(size=n), rng.normal(size=(m, n))
    return A @ A.T + 1e-4 * np.eye(n), 10 * rng.normal(size=n), G, G @ x - rng.choice([0.0, 1.0], m) * rng.uniform(0, 1, m), x


@pytest.mark.parametrize("n", [1, 3, 7, 14])
@pytest.mark.parametrize("condition", [1.0, 1e-2])
def test_a_solution_has_the_multipliers_of_a_minimum(rng, n, condition):
    for _ in range(100):
        H, f, G, b, x_0 = problem(rng, n, 3 * n + 4, condition)
        x, multipliers = solved(H, f, G, b, x_0)
        size = np.abs(f).max() + np.abs(H).max() * np.abs(x).max()
        assert (G @ x - b).min() >= -1e-9 * (1 + np.abs(x).max())
        assert multipliers.min() >= -1e-7 * size
        np.testing.assert_allclose(H @ x - f, G.T @ multipliers, atol=1e-6 * size)
        assert np.abs(multipliers * (G @ x - b)).max() <= 1e-6 * size * (1 + np.abs(x).max())


def test_without_a_row_in_the_way_it_is_the_solution_of_the_equations(rng):
    H, f, G, _, x_0 = problem(rng, 7, 20, 1.0)
    x, multipliers = solved(H, f, G, np.full(20, -1e9), x_0)
    np.testing.assert_allclose(x, np.linalg.solve(H, f), rtol=1e-8)
    assert not multipliers.any()


def test_rows_that_repeat_each_other_do_no_harm(rng):
    """As two bodies of one link near one wall."""
    for _ in range(100):
        H, f, G, b, x_0 = problem(rng, 7, 10, 1.0)
        G, b = np.concatenate([G, G, G * (1 + 1e-14)]), np.concatenate([b, b, b])
        x, _ = solved(H, f, G, b, x_0)
        once, _ = solved(H, f, G[:10], b[:10], x_0)
        np.testing.assert_allclose(x, once, atol=1e-7 * (1 + np.abs(once).max()))


def test_a_point_that_no_row_lets_go_stays(rng):
    """Between bounds that are equal."""
    x_0 = rng.normal(size=3)
    G, b = np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([x_0, -x_0])
    x, _ = solved(np.eye(3), rng.normal(size=3), G, b, x_0)
    np.testing.assert_array_equal(x, x_0)


@pytest.mark.parametrize("k", [0, 1, 3])
def test_a_system_is_solved_on_the_active_rows(rng, k):
    """By the conditions of Karush, Kuhn and Tucker, in one system by NumPy."""
    n = 7
    for _ in range(50):
        H, b, G, values, _ = problem(rng, n, k, 1e-2)
        active, program, factor = np.arange(k)[::-1].copy(), program_of(np.zeros((0, n)), np.zeros(0)), H.ravel().copy()
        minimize(factor, b.copy(), program, 0, np.zeros(n))
        x, multipliers = b.copy(), np.concatenate([values[active], np.zeros(n - k)])
        solve_on_rows(factor, G.ravel(), active, multipliers, k, x, program.work_rows)
        rows = G[active].reshape(k, n)
        right = np.linalg.solve(np.block([[H, rows.T], [rows, np.zeros((k, k))]]), np.r_[b, values[active]])
        np.testing.assert_allclose(x, right[:n], rtol=1e-6, atol=1e-8 * np.abs(right[:n]).max())
        np.testing.assert_allclose(multipliers[:k], right[n:], rtol=1e-6, atol=1e-6 * np.abs(right).max())
