"""Steepest descent: the error never rises, the limits hold, and what it says of itself is true."""

from itertools import pairwise

import numpy as np
import pytest

import naive
import zoo
from close import assert_close
from ulna.kernels import search_layout as layout
from ulna.kernels.jacobian_transpose import transpose_each
from ulna.kernels.search_layout import NOT_A_POSE, NOT_FOUND, SOLVED, STATIONARY
from ulna.model.description import Limits
from ulna.model.tree import build_tree

N = 10


def search(tree, link, seeds, targets, max_iterations=10_000, tolerance=1e-5):
    """q and the information of every target."""
    settings = np.zeros(layout.N_SETTINGS)
    settings[layout.POSITION_TOLERANCE] = settings[layout.ROTATION_TOLERANCE] = tolerance
    settings[layout.MAX_ITERATIONS] = max_iterations
    q, info = np.full(seeds.shape, np.nan), np.full((len(targets), layout.N_INFO), np.nan)
    with np.errstate(invalid="ignore"):
        transpose_each(tree.chain(link), np.array([tree.lower, tree.upper]), seeds, targets, settings, q, info)
    return q, info


def naive_errors(description, q, link, targets):
    """Distance and angle of the link from each target."""
    poses = [naive.link_pose(description, x, link) for x in q]
    angles = [np.linalg.norm(naive.logarithm(T[:3, :3] @ P[:3, :3].T)) for T, P in zip(targets, poses, strict=True)]
    return np.array([np.linalg.norm(T[:3, 3] - P[:3, 3]) for T, P in zip(targets, poses, strict=True)]), np.array(angles)


@pytest.fixture
def problem(panda, rng):
    """Seeds, and reachable targets about 0.3 rad away from them in each joint."""
    seeds = rng.uniform(panda.lower, panda.upper, (N, 7))
    goals = np.clip(seeds + rng.uniform(-0.3, 0.3, (N, 7)), panda.lower, panda.upper)
    return seeds, np.array([naive.link_pose(panda.description, q, "panda_ee") for q in goals])


def test_the_error_never_rises_from_step_to_step(panda, problem):
    seeds, targets = problem
    squares = []
    for budget in [*range(12), 20, 40]:
        q, info = search(panda.tree, "panda_ee", seeds, targets, budget)
        position, rotation = naive_errors(panda.description, q, "panda_ee", targets)
        assert_close(info[:, layout.POSITION_ERROR], position, atol=1e-13)
        assert_close(info[:, layout.ROTATION_ERROR], rotation, atol=1e-13)
        squares.append(position**2 + rotation**2)
    assert all((later <= before).all() for before, later in pairwise(squares))
    assert (squares[-1] < 0.2 * squares[0]).all()


def test_a_step_that_would_overshoot_is_not_taken(rng):
    """Targets metres out of reach pull a planar arm so hard that the step of a linear arm would carry it past them."""
    arm = zoo.of_chain(*["continuous"] * 2, "fixed", origin=naive.transform(p=(1.0, 0, 0)))
    tree, seeds = build_tree(arm), rng.uniform(-1, 1, (N, 2))
    places = [(5 * np.cos(a), 5 * np.sin(a), 0) for a in rng.uniform(-2, 2, N)]
    targets = np.array([naive.transform(naive.rotation(zoo.Z, rng.uniform(-2, 2)), p) for p in places])
    squares, paths = [], []
    for budget in range(15):
        q, _ = search(tree, "l3", seeds, targets, budget)
        position, rotation = naive_errors(arm, q, "l3", targets)
        squares.append(position**2 + rotation**2)
        paths.append(q)
    assert all((later <= before + 1e-14).all() for before, later in pairwise(squares))
    refused = np.array([(later == before).all(axis=1) for before, later in pairwise(paths)])
    assert refused[:5].any(), "no step was too long: the sample proves nothing"
    assert (refused[:-1] & ~refused[1:]).any(), "and none was shortened and then taken"


def test_no_steps_leave_the_seed(panda, problem):
    seeds, targets = problem
    q, info = search(panda.tree, "panda_ee", seeds, targets, 0)
    assert np.array_equal(q, seeds)
    assert set(info[:, layout.STATUS]) == {NOT_FOUND}
    assert not info[:, layout.ITERATIONS].any()


def test_a_target_that_is_met_is_met_within_the_tolerance_and_the_limits(panda, problem):
    seeds, targets = problem
    q, info = search(panda.tree, "panda_ee", seeds, targets, 300, tolerance=1e-2)
    solved = info[:, layout.STATUS] == SOLVED
    assert solved.sum() >= N // 2
    position, rotation = naive_errors(panda.description, q, "panda_ee", targets)
    assert (position[solved] <= 1e-2).all()
    assert (rotation[solved] <= 1e-2).all()
    assert ((position > 1e-2) | (rotation > 1e-2))[~solved].all()
    assert (q >= panda.lower).all()
    assert (q <= panda.upper).all()


def test_a_seed_at_the_target_needs_no_step(panda, problem):
    seeds, _ = problem
    targets = np.array([naive.link_pose(panda.description, q, "panda_ee") for q in seeds])
    q, info = search(panda.tree, "panda_ee", seeds, targets)
    assert set(info[:, layout.STATUS]) == {SOLVED}
    assert not info[:, layout.ITERATIONS].any()
    assert np.array_equal(q, seeds)


def test_a_slide_comes_to_rest_beside_a_target_that_it_cannot_reach():
    tree = build_tree(zoo.two_links("prismatic", zoo.X))
    targets = np.array(
        [naive.transform(p=(2.0, 1.0, 0.0)), naive.transform(p=(0.0, 1.0, 0.0)), naive.transform(p=(2.0, 0.0, 0.0))]
    )
    q, info = search(tree, "b", np.zeros((3, 1)), targets)
    assert_close(q[:, 0], [2, 0, 2], atol=1e-15)  # one step meets a linear arm's target
    assert list(info[:, layout.STATUS]) == [STATIONARY, STATIONARY, SOLVED]
    assert_close(info[:, layout.POSITION_ERROR], [1, 1, 0], atol=1e-15)
    assert list(info[1:, layout.ITERATIONS]) == [0, 1]


def test_a_slide_stops_at_its_limit():
    tree = build_tree(zoo.two_links("prismatic", zoo.X, limits=Limits(-0.5, 0.25)))
    q, info = search(tree, "b", np.zeros((2, 1)), np.array([naive.transform(p=(x, 0, 0)) for x in (2, -2)]))
    assert list(q[:, 0]) == [0.25, -0.5]
    assert set(info[:, layout.STATUS]) == {STATIONARY}


def test_each_target_is_searched_for_alone(panda, problem):
    seeds, targets = problem
    q, info = search(panda.tree, "panda_ee", seeds, targets, 15)
    for k in (0, 7, 8, 9):
        alone, its_info = search(panda.tree, "panda_ee", seeds[k : k + 1], targets[k : k + 1], 15)
        assert np.array_equal(alone[0], q[k])
        assert np.array_equal(its_info[0], info[k])


def test_what_is_no_pose_is_told_and_spoils_no_other_target(panda, problem):
    seeds, targets = problem
    _, before = search(panda.tree, "panda_ee", seeds, targets, 10)
    spoilt = targets.copy()
    spoilt[1, 0, 3], spoilt[2, 3, 0], spoilt[3, :3, :3] = np.inf, 0.1, -targets[3, :3, :3]
    spoilt[4, 1, 1] = np.nan
    _, info = search(panda.tree, "panda_ee", seeds, spoilt, 10)
    assert set(info[1:5, layout.STATUS]) == {NOT_A_POSE}
    assert np.array_equal(info[[0, *range(5, N)]], before[[0, *range(5, N)]])
