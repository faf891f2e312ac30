"""The textbook searches, step by step beside a twin that uses NumPy's linear algebra and poses by plain products."""

from itertools import pairwise

import numpy as np
import pytest

import formulas
import robots
from assertions import assert_close
from textbook_search import search
from ulna.description.robot_description import Limits
from ulna.drivers.single_start import LARGEST_STEP
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.ik.search_layout import (
    DAMPED_LEAST_SQUARES,
    JACOBIAN_TRANSPOSE,
    NOT_A_POSE,
    NOT_FOUND,
    PSEUDO_INVERSE,
    SOLVED,
    STATIONARY,
)
from ulna.kernels.ik.textbook import CUTOFF, DAMPING
from ulna.kinematics.tree import build_tree

N = 10
METHODS = {"transpose": JACOBIAN_TRANSPOSE, "damped": DAMPED_LEAST_SQUARES, "pseudo-inverse": PSEUDO_INVERSE}
methods = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


def full_step(method, J, e):
    """The step that a method's textbook formula gives."""
    if method == PSEUDO_INVERSE:
        return np.linalg.pinv(J, rcond=CUTOFF) @ e
    if method == DAMPED_LEAST_SQUARES:
        return J.T @ formulas.damped_solution(J, e, DAMPING)
    v = J @ J.T @ e
    return J.T @ e * (e @ v) / (v @ v)


@pytest.fixture
def problem(panda, rng):
    """Seeds, and reachable targets about 0.3 rad away from them in each joint; two seeds stand at a limit."""
    seeds = rng.uniform(panda.lower, panda.upper, (N, 7))
    seeds[0, 1], seeds[1, 3] = panda.lower[1], panda.upper[3]
    goals = np.clip(seeds + rng.uniform(-0.3, 0.3, (N, 7)), panda.lower, panda.upper)
    return seeds, np.array([formulas.link_pose(panda.description, q, "panda_ee") for q in goals])


@methods
def test_a_step_is_the_textbooks(panda, problem, method):
    seeds, targets = problem
    q, info = search(method, panda.tree, "panda_ee", seeds, targets, 1)
    for k in range(N):
        e, J = formulas.pose_error(panda.description, seeds[k], "panda_ee", targets[k]), panda.jacobian(seeds[k])
        push = J.T @ e
        J[:, ((seeds[k] <= panda.lower) & (push < 0)) | ((seeds[k] >= panda.upper) & (push > 0))] = 0.0
        step = full_step(method, J, e)
        step *= min(1.0, LARGEST_STEP / abs(step).max())
        assert_close(q[k], np.clip(seeds[k] + step, panda.lower, panda.upper), atol=1e-9)
        assert info[k, layout.ITERATIONS] == 1


@methods
def test_without_a_step_the_seed_is_reported_with_its_errors(panda, problem, method):
    seeds, targets = problem
    q, info = search(method, panda.tree, "panda_ee", seeds, targets, 0)
    assert np.array_equal(q, seeds)
    assert set(info[:, layout.STATUS]) == {NOT_FOUND}
    assert not info[:, layout.ITERATIONS].any()
    for k in range(N):
        e = formulas.pose_error(panda.description, seeds[k], "panda_ee", targets[k])
        assert_close(
            info[k, layout.RESIDUAL :], np.concatenate([targets[k, :3, :3].T @ half for half in (e[:3], e[3:])]), atol=1e-12
        )


@methods
def test_a_seed_at_the_target_needs_no_step(panda, problem, method):
    seeds, _ = problem
    targets = np.array([formulas.link_pose(panda.description, q, "panda_ee") for q in seeds])
    q, info = search(method, panda.tree, "panda_ee", seeds, targets)
    assert set(info[:, layout.STATUS]) == {SOLVED}
    assert not info[:, layout.ITERATIONS].any()
    assert np.array_equal(q, seeds)


@methods
def test_a_target_that_is_met_is_met_within_the_tolerance_and_the_limits(panda, problem, method):
    seeds, targets = problem
    q, info = search(method, panda.tree, "panda_ee", seeds, targets, 300, tolerance=1e-2)
    solved = info[:, layout.STATUS] == SOLVED
    assert solved.sum() >= N // 2
    e = np.array([formulas.pose_error(panda.description, x, "panda_ee", T) for x, T in zip(q, targets, strict=True)])
    near = (np.linalg.norm(e[:, :3], axis=1) <= 1e-2) & (np.linalg.norm(e[:, 3:], axis=1) <= 1e-2)
    assert np.array_equal(solved, near)
    assert (q >= panda.lower).all()
    assert (q <= panda.upper).all()


@methods
def test_each_target_is_searched_for_alone(panda, problem, method):
    seeds, targets = problem
    q, info = search(method, panda.tree, "panda_ee", seeds, targets, 15)
    for k in (0, 7, 8, 9):
        alone, its_info = search(method, panda.tree, "panda_ee", seeds[k : k + 1], targets[k : k + 1], 15)
        assert np.array_equal(alone[0], q[k])
        assert np.array_equal(its_info[0], info[k])


@methods
def test_what_is_no_pose_is_reported_and_spoils_no_other_target(panda, problem, method):
    seeds, targets = problem
    _, before = search(method, panda.tree, "panda_ee", seeds, targets, 10)
    spoilt = targets.copy()
    spoilt[1, 0, 3], spoilt[2, 3, 0], spoilt[3, :3, :3] = np.inf, 0.1, -targets[3, :3, :3]
    spoilt[4, 1, 1] = np.nan
    _, info = search(method, panda.tree, "panda_ee", seeds, spoilt, 10)
    assert set(info[1:5, layout.STATUS]) == {NOT_A_POSE}
    assert np.array_equal(info[[0, *range(5, N)]], before[[0, *range(5, N)]])


@methods
def test_the_trace_reports_each_step_as_it_was(panda, problem, method):
    seeds, targets = problem
    steps = 12
    _, info, trace = search(method, panda.tree, "panda_ee", seeds[:1], targets[:1], steps, 1e-9, trace=True)
    path = [search(method, panda.tree, "panda_ee", seeds[:1], targets[:1], k, 1e-9)[0][0] for k in range(steps + 1)]
    e = np.array([formulas.pose_error(panda.description, x, "panda_ee", targets[0]) for x in path])
    n = int(info[0, layout.ITERATIONS]) + 1
    assert n > 3
    assert_close(trace[:n, 0], np.linalg.norm(e[:, :3], axis=1)[:n], atol=1e-12)
    assert_close(trace[:n, 1], np.linalg.norm(e[:, 3:], axis=1)[:n], atol=1e-12)
    assert_close(trace[1:n, 2], [abs(b - a).max() for a, b in pairwise(path)][: n - 1], atol=1e-15)
    assert_close(trace[1:n, 3], DAMPING if method == DAMPED_LEAST_SQUARES else 0.0, atol=0)


def test_at_a_singularity_the_pseudo_inverse_takes_the_step_of_numpys_own():
    """A straight planar arm: the error along it is out of its power, the error across is met by all joints together."""
    arm = robots.of_chain(*["continuous"] * 3, "fixed", origin=formulas.transform(p=(1.0, 0, 0)))
    tree, target = (
        build_tree(arm),
        formulas.transform(formulas.rotation(robots.Z, 0.05), (3.9, 0.02, 0.0)),
    )
    q, _ = search(PSEUDO_INVERSE, tree, "l4", np.zeros((1, 3)), target[None], 1)
    J, e = formulas.jacobian(arm, np.zeros(3), "l4"), formulas.pose_error(arm, np.zeros(3), "l4", target)
    assert np.linalg.matrix_rank(J, tol=1e-6) == 2
    assert_close(q[0], np.linalg.pinv(J, rcond=CUTOFF) @ e, atol=1e-9)


@pytest.mark.parametrize("method", [DAMPED_LEAST_SQUARES, PSEUDO_INVERSE])
def test_where_no_joint_can_help_the_search_is_stationary_at_once(method):
    arm = robots.of_chain(*["continuous"] * 3, "fixed", origin=formulas.transform(p=(1.0, 0, 0)))
    q, info = search(method, build_tree(arm), "l4", np.zeros((1, 3)), formulas.transform(p=(3.5, 0, 0.2))[None])
    assert (info[0, layout.STATUS], info[0, layout.ITERATIONS]) == (STATIONARY, 0)
    assert not q.any()


@pytest.mark.parametrize("method", [DAMPED_LEAST_SQUARES, PSEUDO_INVERSE])
def test_no_joint_steps_further_than_the_largest_step(method, rng):
    arm = robots.of_chain(*["continuous"] * 2, "fixed", origin=formulas.transform(p=(1.0, 0, 0)))
    tree, seeds = build_tree(arm), rng.uniform(-3, 3, (N, 2))
    targets = np.tile(formulas.transform(p=(50.0, 20.0, 0)), (N, 1, 1))
    longest = []
    for k in range(6):
        before, after = (search(method, tree, "l3", seeds, targets, n)[0] for n in (k, k + 1))
        longest.append(abs(after - before).max())
    assert max(longest) == pytest.approx(LARGEST_STEP, abs=1e-12)


def test_a_slide_stops_at_its_limit():
    tree = build_tree(robots.two_links("prismatic", robots.X, limits=Limits(-0.5, 0.25)))
    targets = np.array([formulas.transform(p=(x, 0, 0)) for x in (2, -2)])
    for method in METHODS.values():
        q, info = search(method, tree, "b", np.zeros((2, 1)), targets)
        assert list(q[:, 0]) == [0.25, -0.5]
        assert set(info[:, layout.STATUS]) == {STATIONARY}
