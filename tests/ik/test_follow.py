"""``robot.follow``: paths known from joint paths; judged by forward kinematics, and by a graph written out plainly."""

import itertools

import numpy as np
import pytest

import robots
import ulna
from every_lift import least_costs, nodes_of
from ulna import InputError, Robot
from ulna.ik.following import layers
from ulna.ik.following.layers import make_layers

TURN, H = 2 * np.pi, np.pi / 2
Q = np.array([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])


def ur5(limit=np.pi):
    return Robot.from_dh(robots.UR5, convention="standard", limits=[(-limit, limit)] * 6)


def swings(robot, n, seed=1, swing=0.25):
    """A smooth joint path about the middle of the range."""
    rng = np.random.default_rng(seed)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    waves, phases = rng.uniform(0.5, 1.5, robot.n_dof), rng.uniform(0, TURN, robot.n_dof)
    time = np.linspace(0.0, 1.0, n)[:, None]
    return (lower + upper) / 2 + swing * (upper - lower) * np.sin(TURN * waves * time + phases)


def assert_followed(robot, path, T, max_step=0.1):
    """What must hold of any path, from nothing but forward kinematics and differences."""
    assert path.success, str(path)
    assert path.q.shape == (len(T), robot.n_dof)
    assert ((path.q >= robot.lower) & (path.q <= robot.upper)).all()
    assert np.abs(robot.forward_kinematics(path.q) - T).max() < 3e-5
    every = path.q if path.q_start is None else np.vstack([path.q_start, path.q])
    assert np.abs(np.diff(every, axis=0)).max(initial=0.0) <= max_step
    assert np.array_equal(path.steps, np.abs(np.diff(every, axis=0)).max(axis=1))


def chains(robot, T, max_step, begin=None):
    """The least sum of squared steps of a path to each pose, over all solutions with all whole turns; infinite if none."""
    nodes = []
    for pose in T:
        found = robot.all_solutions(pose, whole_turns=True)
        nodes.append(found.q[found.valid])
    cost = np.zeros(len(nodes[0]))
    if begin is not None:
        cost[np.abs(nodes[0] - begin).max(axis=1) > max_step] = np.inf
    least = [cost.min(initial=np.inf)]
    for a, b in itertools.pairwise(nodes):
        following = np.full(len(b), np.inf)
        for j, q in enumerate(b):
            for i, before in enumerate(a):
                if np.abs(q - before).max() <= max_step:
                    following[j] = min(following[j], cost[i] + ((q - before) ** 2).sum())
        cost = following
        least.append(cost.min(initial=np.inf))
    return np.array(least)


# ---- paths that are there


@pytest.mark.parametrize("name", ["panda", "ur5", "planar"])
def test_the_poses_of_a_smooth_joint_path_are_followed(name):
    robot = {"panda": lambda: ulna.load("panda"), "ur5": ur5, "planar": five_joints}[name]()
    known = swings(robot, 300)
    T = robot.forward_kinematics(known)
    for start in (None, known[0]):
        path = robot.follow(T, start)
        assert_followed(robot, path, T)
        if start is not None:
            assert np.abs(path.q[0] - start).max() <= 0.1


def five_joints():
    """Five joints without a closed form: the poses they reach are a few, each with isolated solutions."""
    rows = [(0, 0.3, np.pi / 2, 0), (0.4, 0.05, 0.3, 0), (0.3, 0, -0.4, 0), (0, 0.1, np.pi / 2, 0), (0, 0.2, 0, 0)]
    return Robot.from_dh(rows, convention="standard", limits=[(-2.5, 2.5)] * 5)


def test_an_arm_whose_axes_fit_no_family_is_followed_too():
    rows = [(a + 0.01, d + 0.02, alpha + 0.03, theta) for a, d, alpha, theta in robots.UR5]
    robot = Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * 6)
    assert robot.closed_form is None
    T = robot.forward_kinematics(swings(robot, 150))
    path = robot.follow(T)
    assert_followed(robot, path, T)
    assert path.proof == "searched"


def test_one_pose_is_a_path(panda):
    T = panda.forward_kinematics(panda.home)[None]
    path = panda.follow(T, panda.home)
    assert_followed(panda, path, T)
    assert path.steps.shape == (1,)
    assert panda.follow(T).steps.shape == (0,)


def test_a_wrist_goes_through_its_singularity_and_out_again():
    robot = ur5()
    known = Q + np.linspace(-0.5, 0.5, 41)[:, None] * [0, 0, 0, 0, 1.0, 0]
    known[:, 4] -= 1.1
    known[20, 4] = 0.0
    T = robot.forward_kinematics(known)
    assert robot.all_solutions(T[20]).proof == "continuum"
    path = robot.follow(T, known[0])
    assert_followed(robot, path, T)
    assert path.proof == "searched"


@pytest.mark.parametrize("rows", ["UR5", "PUMA"])
def test_a_wrist_that_is_singular_all_along_has_as_many_solutions_a_pose_however_long_the_path(rows, monkeypatch):
    robot = Robot.from_dh(getattr(robots, rows), convention="standard", limits=[(-np.pi, np.pi)] * 6)
    known = Q + np.linspace(0.0, 1.0, 24)[:, None] * [0.5, 0.4, -0.5, 0.3, 0.0, 0.2]
    known[:, 4] = 0.0
    most = []

    def counted(course):
        layers = make_layers(course)
        most.append(max(map(len, layers[0])))
        return layers

    monkeypatch.setattr(layers, "make_layers", counted)
    T = robot.forward_kinematics(known)
    for start in (known[0], None):
        path = robot.follow(T, start)
        assert_followed(robot, path, T)
        assert path.proof == "searched"
        begin = robot.home if start is None else start
        sums = [(np.diff(np.vstack([begin, q]), axis=0) ** 2).sum() for q in (path.q, known)]
        assert sums[0] <= sums[1]
    assert max(most) <= 8 + 2 * 16


# ---- the best of all paths


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("max_step", [0.5, 1.5, 3.0, 4.3])
def test_the_step_from_the_start_is_one_of_those_whose_squares_are_summed(seed, max_step):
    rng = np.random.default_rng(seed)
    limits = [(-np.pi, np.pi)] * 6
    robot = Robot.from_dh(robots.PUMA, convention="standard", limits=limits)
    known = rng.uniform(-2.0, 2.0, 6) + rng.uniform(-0.4, 0.4, (3, 6)).cumsum(axis=0)
    T, start = robot.forward_kinematics(known), known[0] + rng.uniform(-0.3, 0.3, 6)
    path = robot.follow(T, start, max_step=max_step)
    assert_followed(robot, path, T, max_step)
    assert np.array_equal(path.q_start, start)
    assert path.steps.shape == (3,)
    least = least_costs(nodes_of(robots.PUMA, limits, T), max_step, start)[-1]
    assert (np.diff(np.vstack([start, path.q]), axis=0) ** 2).sum() == pytest.approx(least, rel=1e-9)
    assert robot.follow(T, max_step=max_step).steps.shape == (2,)


@pytest.mark.parametrize("seed", range(8))
def test_without_a_start_the_step_from_home_is_one_of_them_however_long(seed):
    rng = np.random.default_rng(seed)
    limits = [(-np.pi, np.pi)] * 6
    robot = Robot.from_dh(robots.PUMA, convention="standard", limits=limits)
    T = robot.forward_kinematics(rng.uniform(-2.0, 2.0, 6) + rng.uniform(-0.4, 0.4, (3, 6)).cumsum(axis=0))
    path = robot.follow(T, max_step=1.5)
    assert_followed(robot, path, T, 1.5)
    home, *nodes = [robot.home[None], *nodes_of(robots.PUMA, limits, T)]
    sums = [(np.diff(np.vstack([home, q]), axis=0) ** 2).sum() for q in itertools.product(*nodes) if within(q, 1.5)]
    assert (np.diff(np.vstack([home, path.q]), axis=0) ** 2).sum() == pytest.approx(min(sums), rel=1e-9)
    assert path.q_start is None


def within(q, max_step):
    return np.abs(np.diff(q, axis=0)).max() <= max_step


def test_a_panda_without_a_start_begins_near_home(panda):
    T = panda.forward_kinematics(panda.home + np.linspace(0.0, 0.5, 20)[:, None])
    assert np.abs(panda.follow(T).q[0] - panda.home).max() < 1e-3


def test_no_branch_is_taken_far_from_the_start_to_save_a_little_later():
    rows = [(0.15, 0.45, -H, 0), (0.6, 0, 0, -H), (0.2, 0, -H, 0), (0, 0.64, H, 0), (0, 0, -H, 0), (0, 0.1, 0, 0)]
    robot = Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * 6)
    q = np.array([[-1.81, 2.237, 0.395, 1.967, 0.988, -1.333], [-0.82, 1.675, -2.463, 1.331, 1.276, -2.967]])
    path = robot.follow(robot.forward_kinematics(q), q[0], max_step=4.28)
    assert np.abs(path.q[0] - q[0]).max() < 1e-9
    assert path.steps[0] < 1e-9


@pytest.mark.parametrize("seed", range(6))
def test_the_path_is_the_best_of_all_by_a_graph_written_out(seed):
    robot = ur5()
    T = robot.forward_kinematics(swings(robot, 25, seed, swing=0.4))
    for max_step in (0.15, 0.6):
        least, path = chains(robot, T, max_step), robot.follow(T, max_step=max_step)
        assert path.proof == "complete"
        if np.isfinite(least[-1]):
            assert_followed(robot, path, T, max_step)
            assert (np.diff(path.q, axis=0) ** 2).sum() == pytest.approx(least[-1], rel=1e-9)
        else:
            assert path.ends_at == np.flatnonzero(np.isinf(least))[0]


def test_whole_turns_are_taken_within_the_limits_and_no_further():
    robot = ur5(limit=1.25 * TURN)
    known = Q + np.linspace(0.0, 1.0, 120)[:, None] * [1.2 * TURN - 0.3 + 0.9 * TURN, 0, 0, 0, 0, 0]
    known[:, 0] -= 0.9 * TURN
    T = robot.forward_kinematics(known)
    path = robot.follow(T, max_step=0.2)
    assert_followed(robot, path, T, 0.2)
    assert np.abs(path.q - known)[:, 0].max() < 1e-6  # only one of all turns to begin with leaves enough
    path = robot.follow(T, known[0] + [TURN, 0, 0, 0, 0, 0], max_step=0.2)
    assert path.status == "joint limits"


@pytest.mark.parametrize("turns", [3, 4, 9, 40])
def test_a_joint_screws_from_one_limit_to_the_other_however_wide_they_are(turns):
    limits = [*[(-np.pi, np.pi)] * 5, (-turns * np.pi, turns * np.pi)]
    robot = Robot.from_dh(robots.UR5, convention="standard", limits=limits)
    known = np.tile(Q, (20 * turns, 1))
    known[:, 5] = np.linspace(-0.95, 0.95, len(known)) * turns * np.pi
    T = robot.forward_kinematics(known)
    for start in (known[0], None):
        path = robot.follow(T, start, max_step=0.4)
        assert_followed(robot, path, T, 0.4)
        assert path.proof == "complete"
        assert start is None or np.abs(path.q - known).max() < 1e-6


def test_of_too_many_turns_those_about_the_start_are_searched_and_the_reason_says_so():
    wide = (-20 * TURN, 20 * TURN)
    robot = Robot.from_dh(robots.UR5, convention="standard", limits=[wide, *[(-np.pi, np.pi)] * 4, wide])
    known = np.tile(Q, (300, 1))
    known[:, 0] += 3 * TURN
    known[:, 5] += np.linspace(0.0, 15 * TURN, 300)
    T = robot.forward_kinematics(known)
    path = robot.follow(T[:200], known[0], max_step=0.5)
    assert_followed(robot, path, T[:200], 0.5)
    assert np.abs(path.q - known[:200]).max() < 1e-6
    assert path.proof == "searched"
    path = robot.follow(T, known[0], max_step=0.5)
    assert (path.status, path.proof) == ("no continuous branch", "searched")
    assert str(path.reason).startswith("27 turns of joint6 about the start were searched, fewer than the limits allow")
    assert path.reason.data.smallest_step == pytest.approx(15 * TURN / 299)
    rest = robot.follow(T[path.ends_at :], path.q[path.ends_at - 1], max_step=0.5)
    assert rest.success
    assert np.abs(rest.q - known[path.ends_at :]).max() < 1e-6


def test_a_wheel_turns_as_often_as_the_path_asks():
    robot = Robot.from_dh(robots.UR5, convention="standard", limits=[*[(-np.pi, np.pi)] * 5, (-np.inf, np.inf)])
    known = Q + np.linspace(0.0, 1.0, 300)[:, None] * [0, 0, 0, 0, 0, 4 * TURN]
    T = robot.forward_kinematics(known)
    path = robot.follow(T, known[0] - [0, 0, 0, 0, 0, TURN], max_step=0.2)
    assert_followed(robot, path, T, 0.2)
    assert path.q[-1, 5] - path.q[0, 5] == pytest.approx(4 * TURN)
    assert path.q[0, 5] == pytest.approx(known[0, 5] - TURN)


def test_joints_that_do_not_move_the_link_stay_at_the_start():
    robot = ur5()
    T = robot.forward_kinematics(swings(robot, 200), link="link5")
    path = robot.follow(T, link="link5")
    assert path.success, str(path)
    assert np.abs(robot.forward_kinematics(path.q, link="link5") - T).max() < 3e-5
    assert np.array_equal(path.q[:, 5], np.full(200, robot.home[5]))


@pytest.mark.parametrize("rank", ["nearest", "manipulability", "mid_range"])
def test_a_rank_chooses_another_of_the_paths(rank):
    robot = ur5()
    T = robot.forward_kinematics(Q + np.linspace(0, 0.5, 20)[:, None] * [1, 0, 0, 0, 0, 0])
    solutions = robot.all_solutions(T)
    costs = {
        "nearest": lambda q: np.abs(q - robot.home).max(axis=-1),
        "manipulability": lambda q: -robot.manipulability(q),
        "mid_range": lambda q: ((q / np.pi) ** 2).mean(axis=-1),
    }
    path = robot.follow(T, rank=rank)
    assert_followed(robot, path, T)
    cost = costs[rank]
    branches = solutions.q[:, solutions.valid.all(axis=0)]
    each = [cost(branches[:, k]).sum() for k in range(branches.shape[1])]  # no branch meets a limit, so each is one path
    assert cost(path.q).sum() <= min(each) + 0.1


# ---- what is refused


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"T_path": np.eye(4)}, "T_path"),
        ({"T_path": np.zeros((0, 4, 4))}, "T_path"),
        ({"T_path": np.full((2, 4, 4), np.nan)}, "T_path"),
        ({"T_path": np.stack([2 * np.eye(4)] * 2)}, "T_path"),
        ({"q_start": np.zeros((2, 7))}, "q_start"),
        ({"q_start": np.full(7, np.nan)}, "q_start"),
        ({"max_step": 0.0}, "max_step"),
        ({"max_step": "far"}, "max_step"),
        ({"rank": "best"}, "rank"),
        ({"rank": "clearance"}, "rank"),
    ],
)
def test_wrong_arguments_are_refused_by_name(panda, change, name):
    arguments = {"T_path": panda.forward_kinematics(panda.home)[None], **change}
    with pytest.raises(InputError, match=name):
        panda.follow(**arguments)
