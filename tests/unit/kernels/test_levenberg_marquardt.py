"""Eight searches at once: what they return is a solution by the twin's forward kinematics, and the lane that should win does."""

import numpy as np
import pytest

import naive
import zoo
from close import assert_close
from ulna.kernels import search_layout as layout
from ulna.kernels.layout import LARGEST
from ulna.kernels.levenberg_marquardt import SEEDED_STEPS, STEPS, solve_each
from ulna.kernels.search_layout import NOT_A_POSE, NOT_FOUND, SOLVED
from ulna.model.description import frozen
from ulna.model.tree import build_tree

N = 12
NO_TARGET = naive.transform(p=(5.0, 0.0, 0.0))  # five metres away


class Search:
    """``solve_each`` with everything that it needs but the question."""

    def __init__(self, tree, link, starts):
        self.tree, self.chain, self.starts = tree, tree.chain(link), frozen(starts, starts.shape)
        self.limits = frozen([tree.lower, tree.upper], (2, tree.n_dof))

    def __call__(self, targets, seeds, *, seeded=False, posture=None, tolerance=1e-5, max_iterations=2000):
        settings = np.zeros(layout.N_SETTINGS)
        settings[layout.POSITION_TOLERANCE] = settings[layout.ROTATION_TOLERANCE] = tolerance
        settings[layout.MAX_ITERATIONS] = max_iterations
        settings[layout.SEEDED], settings[layout.WITH_POSTURE] = seeded, posture is not None
        goal = frozen(np.zeros(self.tree.n_dof) if posture is None else posture, (self.tree.n_dof,))
        q, info = np.full(seeds.shape, np.nan), np.full((len(targets), layout.N_INFO), np.nan)
        with np.errstate(all="ignore"):
            solve_each(self.chain, self.limits, self.starts, seeds, goal, targets, settings, q, info)
        return q, info


def errors(description, q, link, targets):
    """Distance and angle of the link from each target, by the twin."""
    poses = [naive.link_pose(description, x, link) for x in q]
    angles = [np.linalg.norm(naive.logarithm(T[:3, :3] @ P[:3, :3].T)) for T, P in zip(targets, poses, strict=True)]
    return np.array([np.linalg.norm(T[:3, 3] - P[:3, 3]) for T, P in zip(targets, poses, strict=True)]), np.array(angles)


@pytest.fixture
def search(panda, rng):
    share = rng.random((100, 7, 8))
    return Search(panda.tree, "panda_ee", panda.lower[:, None] + share * (panda.upper - panda.lower)[:, None])


@pytest.fixture
def goals(panda, rng):
    """Configurations and the targets at which they put the Panda's end; the last presses against all its limits but one."""
    q = rng.uniform(panda.lower, panda.upper, (N, 7))
    q[-1, :6] = panda.upper[:6]
    return q, np.array([naive.link_pose(panda.description, x, "panda_ee") for x in q])


def test_every_solution_is_one_and_lies_within_the_limits(panda, search, goals):
    _, targets = goals
    q, info = search(targets, np.tile(panda.home, (N, 1)))
    assert set(info[:, layout.STATUS]) == {SOLVED}
    position, rotation = errors(panda.description, q, "panda_ee", targets)
    assert position.max() < 1e-9, "the polish leaves far less than the tolerance"
    assert rotation.max() < 1e-9
    assert (q >= panda.lower).all()
    assert (q <= panda.upper).all()
    assert_close(info[:, layout.POSITION_ERROR], position, atol=1e-13)
    assert_close(info[:, layout.ROTATION_ERROR], rotation, atol=1e-13)


def test_a_seed_that_solves_is_kept_where_it_is(search, goals):
    seeds, targets = goals
    q, info = search(targets, seeds, seeded=True)
    assert not info[:, layout.ITERATIONS].any()
    assert_close(q, seeds, atol=1e-6)  # the polish may move it by what is left of the error


def test_a_seed_near_a_solution_is_followed_to_it(panda, search, goals, rng):
    near, targets = goals
    seeds = np.clip(near + rng.uniform(-0.05, 0.05, near.shape), panda.lower, panda.upper)
    q, info = search(targets, seeds, seeded=True)
    assert set(info[:, layout.STATUS]) == {SOLVED}
    assert abs(q - near).max() < 0.5


def test_without_a_seed_the_first_lane_to_solve_wins_and_with_one_the_seeds_own_lane(search, goals):
    """The table's first starts solve the target at once, on another branch than the one the seed leads to."""
    near, targets = goals
    other, _ = search(targets[:1], search.starts[99, :, 0][None])
    assert abs(other[0] - near[0]).max() > 0.5
    search.starts = frozen(np.broadcast_to(other[0][None, :, None], (1, 7, 8)), (1, 7, 8))
    seed = near[:1] + 0.01
    q, info = search(targets[:1], seed)
    assert_close(q, other, atol=1e-6)
    assert info[0, layout.ITERATIONS] == 0
    q, info = search(targets[:1], seed, seeded=True)
    assert abs(q - near[0]).max() < 0.1
    assert info[0, layout.ITERATIONS] > 0


def test_when_the_seeds_own_lane_is_stuck_the_solution_nearest_to_the_seed_wins():
    """A straight planar arm cannot be pulled back along itself: every column is square to the error."""
    arm = zoo.of_chain(*["continuous"] * 3, "fixed", origin=naive.transform(p=(1.0, 0, 0)))
    solution, turn = np.array([0.4, -0.8, 0.4]), np.array([2 * np.pi, 0, -2 * np.pi])
    target = naive.transform(p=(naive.link_pose(arm, solution, "l4")[0, 3], 0, 0))
    lanes = [np.zeros(3), solution + turn, solution - turn, solution, -solution + turn, *[solution - 2 * turn] * 3]
    starts = np.ascontiguousarray(np.transpose(lanes)[None])
    q, info = Search(build_tree(arm), "l4", starts)(target[None], np.zeros((1, 3)), seeded=True)
    assert info[0, layout.STATUS] == SOLVED
    assert info[0, layout.ITERATIONS] == SEEDED_STEPS
    assert_close(q[0], solution, atol=1e-9)


@pytest.mark.parametrize("posture_from", ["home", "zero"])
def test_with_a_posture_no_motion_that_keeps_the_pose_leads_nearer_to_it(panda, search, goals, posture_from):
    near, targets = goals
    posture = panda.home if posture_from == "home" else np.clip(np.zeros(7), panda.lower, panda.upper)
    q, info = search(targets[:6], near[:6], seeded=True, posture=posture)
    solved = info[:, layout.STATUS] == SOLVED
    assert solved.sum() >= 4
    position, rotation = errors(panda.description, q, "panda_ee", targets[:6])
    assert (position[solved] <= 1e-5).all()
    assert (rotation[solved] <= 1e-5).all()
    assert any(((x > panda.lower) & (x < panda.upper)).all() for x in q[solved])
    settled = 0
    for x in q[solved]:
        J = naive.jacobian(panda.description, x, "panda_ee")
        free = np.linalg.svd(J)[2][6]
        at_a_limit = (x == panda.lower) | (x == panda.upper)
        settled += at_a_limit.any() or abs(free @ (posture - x)) < 1e-6
    assert settled >= 4  # the pose comes first: now and then the steps end before the posture is used up


def test_what_is_not_found_returns_the_best_met_after_the_whole_budget(panda, search):
    targets = np.array([NO_TARGET, NO_TARGET])
    q, info = search(targets, np.tile(panda.home, (2, 1)), max_iterations=3 * STEPS)
    assert set(info[:, layout.STATUS]) == {NOT_FOUND}
    assert set(info[:, layout.ITERATIONS]) == {3 * STEPS}
    position, rotation = errors(panda.description, q, "panda_ee", targets)
    assert_close(info[:, layout.POSITION_ERROR], position, atol=1e-13)
    assert_close(info[:, layout.ROTATION_ERROR], rotation, atol=1e-12)
    assert (position < 4.6).all()  # the arm, 1.2 m long with its end, stretches towards it
    assert ((q >= panda.lower) & (q <= panda.upper)).all()


def test_a_larger_budget_never_ends_with_a_larger_error(panda, search):
    squares = []
    for budget in (0, 1, STEPS, 2 * STEPS, 4 * STEPS):
        _, info = search(NO_TARGET[None], panda.home[None], max_iterations=budget)
        assert info[0, layout.ITERATIONS] == budget
        if budget % STEPS == 0 and budget:
            squares.append(info[0, layout.POSITION_ERROR] ** 2 + info[0, layout.ROTATION_ERROR] ** 2)
    assert squares == sorted(squares, reverse=True)


@pytest.mark.parametrize("far", [1e5, 1e6, 1e100, 1e160, 1e300])
def test_a_target_however_far_is_refused_or_leaves_a_configuration_within_the_limits(panda, search, far):
    q, info = search(naive.transform(p=(far, 0, 0))[None], panda.home[None], max_iterations=2 * STEPS)
    assert info[0, layout.STATUS] == NOT_FOUND or (far > LARGEST and info[0, layout.STATUS] == NOT_A_POSE)
    assert ((q >= panda.lower) & (q <= panda.upper)).all() or info[0, layout.STATUS] == NOT_A_POSE


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e9])
def test_what_is_no_pose_is_told_and_spoils_no_other_target(panda, search, goals, bad):
    _, targets = goals
    seeds = np.tile(panda.home, (4, 1))
    q, info = search(targets[:4], seeds)
    for entry in [(0, 0), (2, 1), (3, 3)]:
        spoilt = targets[:4].copy()
        spoilt[(1, *entry)] = bad
        q_beside, info_beside = search(spoilt, seeds)
        assert info_beside[1, layout.STATUS] == NOT_A_POSE
        assert np.array_equal(q_beside[[0, 2, 3]], q[[0, 2, 3]])
        assert np.array_equal(info_beside[[0, 2, 3]], info[[0, 2, 3]])
