"""Jobs of a search in eight lanes: what they answer is a solution by the twin's forward kinematics, whatever stands beside it."""

import numpy as np
import pytest

import formulas
import robots
from assertions import assert_close
from ulna.ik.entries import multi_start
from ulna.kernels.ik.search_layout import NOT_A_POSE, NOT_FOUND, SOLVED
from ulna.kernels.ik.search_records import SearchResult, SearchSettings
from ulna.kernels.layout import LARGEST
from ulna.kinematics.tree import build_tree

search_jobs, Jobs = multi_start.search_jobs, multi_start.Jobs
N, STARTS, STEPS = 5, 6, 20
NO_TARGET = formulas.transform(p=(5.0, 0.0, 0.0))  # five meters away


class Search:
    """``search_jobs`` with everything that it needs but the question; answers in the shape (targets, starts, ...)."""

    def __init__(self, tree, link, shares):
        self.tree, self.chain, self.shares = tree, tree.chain(link), shares
        self.bounds = np.array([[tree.lower, tree.upper, np.maximum(tree.lower, -np.pi), np.minimum(tree.upper, np.pi)]])

    def __call__(self, targets, seeds, *, order=None, posture=None, tolerance=1e-5, steps=STEPS, first_wins=False):
        n_dof, n_starts = self.tree.n_dof, len(self.shares)
        order = np.arange(len(targets)) if order is None else np.asarray(order)
        records = SearchSettings.records()
        settings = records[0]
        settings.position_tolerance = settings.rotation_tolerance = tolerance
        settings.steps, settings.first_wins, settings.with_posture = steps, first_wins, posture is not None
        goal = np.zeros(n_dof) if posture is None else np.array(posture)
        rows = len(order) * (1 if first_wins else n_starts)
        q, info = np.full((rows, n_dof), np.nan), SearchResult.records(rows)
        for name in SearchResult.structure.names:
            info[name] = np.nan if info[name].dtype == float else -9
        with np.errstate(all="ignore"):
            jobs = Jobs(targets, order, np.array(seeds), self.bounds, self.shares, goal)
            search_jobs(self.chain, records, jobs, q, info)
        return q.reshape(len(order), -1, n_dof), info.reshape(len(order), -1)


def errors(description, q, link, target):
    """Distance and angle of the link from a target at each configuration, by the twin."""
    poses = [formulas.link_pose(description, x, link) for x in q]
    angles = [np.linalg.norm(formulas.logarithm(target[:3, :3] @ P[:3, :3].T)) for P in poses]
    return np.array([np.linalg.norm(target[:3, 3] - P[:3, 3]) for P in poses]), np.array(angles)


@pytest.fixture
def search(panda, rng):
    """From the seed, and from random starts."""
    return Search(panda.tree, "panda_ee", np.vstack([np.full((1, 7), np.nan), rng.random((STARTS - 1, 7))]))


@pytest.fixture
def from_seed(panda):
    return Search(panda.tree, "panda_ee", np.full((1, 7), np.nan))


@pytest.fixture
def goals(panda, rng):
    """Configurations and the targets at which they put the Panda's end; the last presses against all its limits but one."""
    q = rng.uniform(panda.lower, panda.upper, (N, 7))
    q[-1, :6] = panda.upper[:6]
    return q, np.array([formulas.link_pose(panda.description, x, "panda_ee") for x in q])


def test_every_result_has_its_true_errors_and_lies_within_the_bounds(panda, search, goals):
    _, targets = goals
    q, info = search(targets, panda.home[None])
    assert ((q >= panda.lower) & (q <= panda.upper)).all()
    for k in range(N):
        position, rotation = errors(panda.description, q[k], "panda_ee", targets[k])
        assert_close(info["position_error"][k, :], position, atol=1e-13)
        assert_close(info["rotation_error"][k, :], rotation, atol=1e-7)
        solved = info["status"][k, :] == SOLVED
        assert np.array_equal(solved, (position <= 1e-5) & (rotation <= 1e-5))
        assert_close(info["residual_square"][k, :], position**2 + rotation**2, rtol=1e-6, atol=1e-13)
        assert list(info["start"][k, :]) == list(range(STARTS))
    assert (info["status"] == SOLVED).mean() > 0.5
    assert (info["status"] == NOT_FOUND).any()
    failed = info["status"] == NOT_FOUND
    assert set(info["iterations"][failed]) == {STEPS}


def test_the_residual_is_the_error_in_the_targets_axes(panda, from_seed, goals):
    _, targets = goals
    q, info = from_seed(targets, panda.home[None], steps=2)
    for x, T, residual in zip(q[:, 0], targets, info["residual"][:, 0], strict=True):
        pose = formulas.link_pose(panda.description, x, "panda_ee")
        expected = [
            *T[:3, :3].T @ (T[:3, 3] - pose[:3, 3]),
            *T[:3, :3].T @ formulas.logarithm(T[:3, :3] @ pose[:3, :3].T),
        ]
        assert_close(residual, expected, atol=1e-8)


def test_a_job_has_the_same_result_beside_any_others_and_in_any_lane(panda, search, goals):
    _, targets = goals
    q, info = search(targets, panda.home[None])
    for order in ([0], [N - 1], [3, 1], [2, 2, 0, 2], list(range(N))[::-1]):
        q_part, info_part = search(targets, panda.home[None], order=order)
        assert np.array_equal(q_part, q[order])
        assert np.array_equal(info_part, info[order])
    search.shares = search.shares[[0, 4]]
    fewer, info_fewer = search(targets, panda.home[None])
    assert np.array_equal(fewer, q[:, [0, 4]])
    assert np.array_equal(info_fewer["residual"][:, :], info["residual"][:, [0, 4]])


def test_every_target_has_a_seed_and_bounds_of_its_own(panda, from_seed, goals, rng):
    near, targets = goals
    seeds = np.clip(near + rng.uniform(-0.05, 0.05, near.shape), panda.lower, panda.upper)
    from_seed.bounds = np.stack([seeds - 0.3, seeds + 0.3, seeds - 0.3, seeds + 0.3], axis=1)
    from_seed.bounds[1, :2] = seeds[1]
    q, info = from_seed(targets, seeds)
    assert set(info["status"][[0, 2, 3, 4], 0]) == {SOLVED}
    assert info["status"][1, 0] == NOT_FOUND
    assert np.array_equal(q[1, 0], seeds[1])
    assert (abs(q[:, 0] - seeds) <= 0.3 + 1e-15).all()


def test_a_seed_that_solves_is_kept_where_it_is(from_seed, goals):
    seeds, targets = goals
    q, info = from_seed(targets, seeds)
    assert set(info["status"][:, 0]) == {SOLVED}
    assert not info["iterations"][:, 0].any()
    assert_close(q[:, 0], seeds, atol=1e-9)


def test_a_start_beyond_the_bounds_begins_at_them(panda, from_seed, goals):
    _, targets = goals
    q, info = from_seed(targets[:1], panda.upper[None] + 1.0, steps=0)
    assert np.array_equal(q[0, 0], panda.upper)
    assert (info["status"][0, 0], info["iterations"][0, 0]) == (NOT_FOUND, 0)


@pytest.mark.parametrize("steps", [0, 1, 7])
def test_no_start_takes_more_steps_than_it_may(panda, search, steps):
    _, info = search(NO_TARGET[None], panda.home[None], steps=steps)
    assert set(info["iterations"][0, :]) == {steps}
    assert set(info["status"][0, :]) == {NOT_FOUND}


def test_where_the_first_wins_one_row_holds_the_first_that_solves(panda, search, goals):
    _, targets = goals
    every_q, every = search(targets[:1], panda.home[None])
    q, info = search(targets, panda.home[None], order=[0], first_wins=True)
    solved = np.flatnonzero(every["status"][0, :] == SOLVED)
    first = min(solved, key=lambda k: (every["iterations"][0, k], k))
    assert info["status"][0, 0] == SOLVED
    assert info["start"][0, 0] in solved
    assert abs(every["iterations"][0, int(info["start"][0, 0])] - every["iterations"][0, first]) <= 1
    assert np.array_equal(q[0, 0], every_q[0, int(info["start"][0, 0])])


def test_where_the_first_wins_and_none_does_the_nearest_is_reported(panda, search):
    every_q, every = search(NO_TARGET[None], panda.home[None])
    q, info = search(NO_TARGET[None], panda.home[None], first_wins=True)
    nearest = every["residual_square"][0, :].argmin()
    assert np.array_equal(q[0, 0], every_q[0, nearest])
    assert np.array_equal(info[0, 0], every[0, nearest])


@pytest.mark.parametrize("posture_from", ["home", "zero"])
def test_with_a_posture_no_motion_that_keeps_the_pose_leads_nearer_to_it(panda, from_seed, goals, posture_from):
    near, targets = goals
    posture = panda.home if posture_from == "home" else np.clip(np.zeros(7), panda.lower, panda.upper)
    q, info = from_seed(targets[:4], near[:4], posture=posture, steps=60)
    settled = 0
    for x, T, status in zip(q[:, 0], targets, info["status"][:, 0], strict=False):
        if status == SOLVED:
            assert np.max(errors(panda.description, [x], "panda_ee", T)) <= 1e-5
            free = np.linalg.svd(formulas.jacobian(panda.description, x, "panda_ee"))[2][6]
            at_a_limit = (x == panda.lower) | (x == panda.upper)
            settled += at_a_limit.any() or abs(free @ (posture - x)) < 1e-6
    assert settled >= 3  # the pose comes first: now and then the steps end before the posture is used up


def test_a_straight_arm_cannot_be_pulled_back_along_itself():
    """Every column is square to the error: the seed's own start stays where it is, and says so."""
    arm = robots.of_chain(*["continuous"] * 3, "fixed", origin=formulas.transform(p=(1.0, 0, 0)))
    search = Search(build_tree(arm), "l4", np.full((1, 3), np.nan))
    q, info = search(formulas.transform(p=(3.5, 0, 0))[None], np.zeros((1, 3)))
    assert info["status"][0, 0] == NOT_FOUND
    assert_close(q[0, 0], np.zeros(3), atol=0)


@pytest.mark.parametrize("far", [1e5, 1e6, 1e100, 1e160, 1e300])
def test_a_target_however_far_is_refused_or_leaves_a_configuration_within_the_limits(panda, from_seed, far):
    q, info = from_seed(formulas.transform(p=(far, 0, 0))[None], panda.home[None])
    assert info["status"][0, 0] == (NOT_FOUND if far <= LARGEST else NOT_A_POSE)
    assert far > LARGEST or ((q >= panda.lower) & (q <= panda.upper)).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e9])
def test_a_seed_that_is_no_configuration_is_reported_and_spoils_no_other(panda, from_seed, goals, bad):
    _, targets = goals
    seeds = np.tile(panda.home, (3, 1))
    q, info = from_seed(targets[:3], seeds)
    seeds[1, 4] = bad
    q_beside, info_beside = from_seed(targets[:3], seeds)
    assert info_beside["status"][1, 0] == NOT_A_POSE
    assert np.array_equal(q_beside[[0, 2]], q[[0, 2]])
    assert np.array_equal(info_beside[[0, 2]], info[[0, 2]])


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e9])
def test_what_is_no_pose_is_reported_and_spoils_no_other_target(panda, search, goals, bad):
    _, targets = goals
    q, info = search(targets[:3], panda.home[None])
    for place in [(0, 0), (2, 1), (3, 3)]:
        spoilt = targets[:3].copy()
        spoilt[(1, *place)] = bad
        q_beside, info_beside = search(spoilt, panda.home[None])
        assert set(info_beside["status"][1, :]) == {NOT_A_POSE}
        assert np.array_equal(q_beside[[0, 2]], q[[0, 2]])
        assert np.array_equal(info_beside[[0, 2]], info[[0, 2]])
    q, info = search(spoilt, panda.home[None], order=[1], first_wins=True)
    assert info["status"][0, 0] == NOT_A_POSE
