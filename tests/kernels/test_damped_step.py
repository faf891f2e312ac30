"""A step of damped least squares against ``numpy.linalg.solve``, and at the bounds against its own words."""

import numpy as np
import pytest

import formulas
import kernel_probes as probes
from assertions import assert_close
from ulna.kernels.ik.levenberg_marquardt import CHANGE, LAMBDA, LAST_ERROR, N_STATE, P2, R2
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.ik.search_records import SearchSettings

N = 16
LINK = "panda_ee"


def problems(rng, n_dof, damping):
    """J of shape (N, 6, n_dof), e (N, 6), and the rows that a probe loads."""
    J, e = rng.normal(size=(N, 6, n_dof)), rng.normal(size=(N, 6))
    return J, e, np.vstack([J.transpose(2, 1, 0).reshape(6 * n_dof, N), np.full(N, damping), e.T])


@pytest.mark.parametrize("n_dof", [1, 2, 5, 6, 7, 12])
@pytest.mark.parametrize("damping", [10.0, 1e-1, 1e-3])
def test_the_system_is_solved_as_numpy_solves_it(run, rng, n_dof, damping):
    J, e, rows = problems(rng, n_dof, damping)
    y = run(probes.damped_system, rows, 27, n_dof)[21:].T
    expected = [formulas.damped_solution(J[k], e[k], damping) for k in range(N)]
    assert_close(
        y / np.linalg.norm(expected, axis=1)[:, None],
        expected / np.linalg.norm(expected, axis=1)[:, None],
        atol=1e-14 * (1 + 10 / damping),
    )


@pytest.mark.parametrize("damping", [1e-6, 1e-9, 1e-12])
def test_with_little_damping_a_redundant_arm_removes_the_error(run, rng, damping):
    J, e, rows = problems(rng, 9, damping)
    y = run(probes.damped_system, rows, 27, 9)[21:].T
    residual = np.einsum("nij,nkj,nk->ni", J, J, y) + damping * y - e
    assert abs(residual).max() < 1e-10


def test_at_a_singularity_damping_keeps_the_step_finite(run):
    J = np.zeros((6, 7))
    J[0] = 1.0
    e, damping = np.arange(1.0, 7.0), 1e-6
    y = run(probes.damped_system, np.concatenate([J.T.ravel(), [damping], e])[:, None], 27, 7)[21:, 0]
    assert_close(y, formulas.damped_solution(J, e, damping), rtol=1e-9)
    assert_close(J.T @ y, np.full(7, 1 / (7 + damping)), rtol=1e-9)


def test_columns_that_press_against_a_bound_are_released(run, rng):
    J, e, _ = problems(rng, 7, 0.0)
    q = rng.choice([-1.0, 0.0, 1.0, np.nextafter(-1, 0), np.nextafter(1, 0)], size=(7, N))
    bounds = np.repeat([-1.0, 1.0], 7)[:, None].repeat(N, axis=1)
    rows = np.vstack([J.transpose(2, 1, 0).reshape(42, N), e.T, q, bounds])
    left = run(probes.columns_that_are_free, rows, 42, 7).T.reshape(N, 7, 6)
    push = np.einsum("nij,ni->nj", J, e)
    pressed = ((q.T == -1) & (push < 0)) | ((q.T == 1) & (push > 0))
    assert pressed.any()
    assert np.array_equal(left, np.where(pressed[..., None], 0.0, J.transpose(0, 2, 1)))


# ---- a step of a search


class Advance:
    """One step of a search for the Panda's end, by the kernel and by the twin."""

    def __init__(self, run, panda, q, targets, bounds, posture=None, tolerance=0.0):
        self.panda, self.q, self.targets, self.bounds, self.posture = panda, q, targets, bounds, posture
        settings, chain = SearchSettings.records(), panda.tree.chain(LINK)
        settings[0].position_tolerance = settings[0].rotation_tolerance = tolerance
        settings[0].with_posture = posture is not None
        rows = np.vstack([q.T, targets[:, :3].reshape(-1, 12).T, bounds.reshape(-1, 14).T])
        goal = np.zeros(7) if posture is None else posture
        out = run(probes.one_advance, rows, 14 + N_STATE + 42 + N_SYSTEM, chain, goal, settings)
        self.moved, self.answer, self.state = out[:7].T, out[7:14].T, out[14:]

    def error(self, k):
        T, target = formulas.link_pose(self.panda.description, self.q[k], LINK), self.targets[k]
        return np.concatenate([target[:3, 3] - T[:3, 3], formulas.logarithm(target[:3, :3] @ T[:3, :3].T)])

    def twin(self, k):
        q, e, (lower, upper) = self.q[k], self.error(k), self.bounds[k]
        J = formulas.jacobian(self.panda.description, q, LINK)
        push = J.T @ e
        J = np.where(((q <= lower) & (push < 0)) | ((q >= upper) & (push > 0)), 0.0, J)
        d = np.zeros(7) if self.posture is None else self.posture - q
        d = d / max(1.0, np.abs(d).max())  # at most a radian a step
        return np.clip(q + d + J.T @ formulas.damped_solution(J, e - J @ d, 0.05 * e @ e + 1e-12), lower, upper)


@pytest.fixture
def there(panda, rng):
    """Configurations, and targets about half a radian away in every joint."""
    q = rng.uniform(panda.lower, panda.upper, (N, 7))
    goals = q + rng.uniform(-0.5, 0.5, (N, 7))
    return q, np.array([formulas.link_pose(panda.description, x, LINK) for x in goals])


def everywhere(n, width):
    return np.tile(np.array([np.full(7, -width), np.full(7, width)]), (n, 1, 1))


@pytest.mark.slow
def test_a_step_is_the_damped_pseudo_inverse(run, panda, there):
    step = Advance(run, panda, *there, everywhere(N, np.inf))
    assert_close(step.moved, [step.twin(k) for k in range(N)], atol=1e-9)
    e = np.array([step.error(k) for k in range(N)])
    assert np.array_equal(step.answer, step.q)
    assert_close(step.state[LAMBDA], 0.05 * np.einsum("ni,ni->n", e, e) + 1e-12, atol=1e-13)
    assert_close(step.state[[P2, R2]], [(e[:, :3] ** 2).sum(axis=1), (e[:, 3:] ** 2).sum(axis=1)], atol=1e-12)


def test_every_lane_stays_within_bounds_of_its_own_and_frees_what_presses_against_them(run, panda, there, rng):
    q, targets = there
    bounds = np.stack([q - rng.choice([0.0, 0.02, 0.3], q.shape), q + rng.choice([0.0, 0.02, 0.3], q.shape)], axis=1)
    step = Advance(run, panda, q, targets, bounds)
    assert_close(step.moved, [step.twin(k) for k in range(N)], atol=1e-9)
    assert (step.moved >= bounds[:, 0]).all()
    assert (step.moved <= bounds[:, 1]).all()
    assert (step.moved == bounds[:, 0]).any()


def test_a_posture_uses_the_freedom_that_the_error_leaves(run, panda, there, rng):
    posture = rng.uniform(panda.lower, panda.upper)
    step = Advance(run, panda, *there, everywhere(N, np.inf), posture)
    expected = np.array([step.twin(k) for k in range(N)])
    assert_close(step.moved, expected, atol=1e-8)
    assert_close(step.state[CHANGE], abs(expected - step.q).max(axis=1), atol=1e-8)


def test_what_is_near_is_noted_and_what_is_not_is_not(run, panda, there):
    q, _ = there
    T = np.array([formulas.link_pose(panda.description, x, LINK) for x in q])
    near = T.copy()
    near[::2, 0, 3] += 0.9e-3
    near[1::2, 0, 3] += 1.1e-3
    step = Advance(run, panda, q, near, everywhere(N, np.inf), tolerance=1e-3)
    assert_close(step.state[LAST_ERROR, ::2], np.full(N // 2, 0.81e-6), atol=1e-12)
    assert np.isinf(step.state[LAST_ERROR, 1::2]).all()
