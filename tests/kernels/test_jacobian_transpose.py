"""Steepest descent: the error never rises, a step that is too long is halved, and where it rests is told."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest

import formulas
import robots
import textbook_search
from assertions import assert_close
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.ik.search_layout import JACOBIAN_TRANSPOSE, SOLVED, STATIONARY
from ulna.kinematics.tree import build_tree

N = 10
search = partial(textbook_search.search, JACOBIAN_TRANSPOSE)


def squares_of(description, q, link, targets):
    """What the search is to lessen: distance squared and angle squared."""
    errors = [formulas.pose_error(description, x, link, T) for x, T in zip(q, targets, strict=True)]
    return np.array([e @ e for e in errors])


@pytest.mark.parametrize("away", [0.3, 1.0])
def test_the_error_never_rises_from_step_to_step(panda, rng, away):
    seeds = rng.uniform(panda.lower, panda.upper, (N, 7))
    goals = np.clip(seeds + rng.uniform(-away, away, (N, 7)), panda.lower, panda.upper)
    targets = np.array([formulas.link_pose(panda.description, q, "panda_ee") for q in goals])
    squares = []
    for budget in [*range(12), 20, 40]:
        q, info = search(panda.tree, "panda_ee", seeds, targets, budget)
        squares.append(squares_of(panda.description, q, "panda_ee", targets))
        assert_close(info[:, layout.POSITION_ERROR] ** 2 + info[:, layout.ROTATION_ERROR] ** 2, squares[-1], atol=1e-12)
    assert all((later <= before).all() for before, later in pairwise(squares))
    assert (squares[-1] < 0.2 * squares[0]).mean() >= 0.9


def test_a_step_that_would_overshoot_is_not_taken(rng):
    """Targets metres out of reach pull a planar arm so hard that the step of a linear arm would carry it past them."""
    arm = robots.of_chain(*["continuous"] * 2, "fixed", origin=formulas.transform(p=(1.0, 0, 0)))
    tree, seeds = build_tree(arm), rng.uniform(-1, 1, (N, 2))
    places = [(5 * np.cos(a), 5 * np.sin(a), 0) for a in rng.uniform(-2, 2, N)]
    targets = np.array([formulas.transform(formulas.rotation(robots.Z, rng.uniform(-2, 2)), p) for p in places])
    squares, paths = [], []
    for budget in range(15):
        q, _ = search(tree, "l3", seeds, targets, budget)
        squares.append(squares_of(arm, q, "l3", targets))
        paths.append(q)
    assert all((later <= before + 1e-14).all() for before, later in pairwise(squares))
    refused = np.array([(later == before).all(axis=1) for before, later in pairwise(paths)])
    assert refused[:5].any(), "no step was too long: the sample proves nothing"
    assert (refused[:-1] & ~refused[1:]).any(), "and none was shortened and then taken"


def test_a_slide_comes_to_rest_beside_a_target_that_it_cannot_reach():
    tree = build_tree(robots.two_links("prismatic", robots.X))
    targets = np.array(
        [
            formulas.transform(p=(0.7, 1.0, 0.0)),
            formulas.transform(p=(0.0, 1.0, 0.0)),
            formulas.transform(p=(0.7, 0.0, 0.0)),
        ]
    )
    q, info = search(tree, "b", np.zeros((3, 1)), targets)
    assert_close(q[:, 0], [0.7, 0, 0.7], atol=1e-15)  # one step meets a linear arm's target
    assert list(info[:, layout.STATUS]) == [STATIONARY, STATIONARY, SOLVED]
    assert_close(info[:, layout.POSITION_ERROR], [1, 1, 0], atol=1e-15)
    assert list(info[1:, layout.ITERATIONS]) == [0, 1]


def test_where_it_rests_no_direction_leads_nearer(rng):
    """One joint, a target beyond its circle: what is left is square to the only column of J."""
    arm = robots.of_chain("continuous", "fixed", origin=formulas.transform(p=(1.0, 0, 0)))
    seeds, target = rng.uniform(-1, 1, (N, 1)), formulas.transform(p=(1.0, 2.0, 0))
    q, info = search(build_tree(arm), "l2", seeds, np.tile(target, (N, 1, 1)))
    assert set(info[:, layout.STATUS]) == {STATIONARY}
    for x in q:
        e, J = formulas.pose_error(arm, x, "l2", target), formulas.jacobian(arm, x, "l2")
        assert abs(J.T @ e) < 1e-6
