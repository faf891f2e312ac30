"""``robot.follow`` with whole turns and limits of every kind, judged by brute force over all solutions with all whole turns."""

import numpy as np
import pytest

import robots
from every_lift import least_costs, nodes_of
from ulna import Robot

TURN, H = 2 * np.pi, np.pi / 2
Q = np.array([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])


def ur5(limits):
    return Robot.from_dh(robots.UR5, convention="standard", limits=limits)


def line(first, last, n):
    """A joint path (n, 6) that is straight."""
    return first + np.linspace(0.0, 1.0, n)[:, None] * (np.asarray(last) - first)


def assert_kept(robot, path, T, start=None):
    """What must hold of every path, found to its end or not."""
    q = path.q[: path.ends_at]
    assert ((q >= robot.lower) & (q <= robot.upper)).all()
    assert np.abs(robot.forward_kinematics(q) - T[: len(q)]).max(initial=0.0) < 3e-5
    assert np.abs(np.diff(q, axis=0)).max(initial=0.0) <= path.max_step + 1e-9
    assert start is None or not len(q) or np.abs(q[0] - start).max() <= path.max_step + 1e-9


def assert_best(robot, limits, T, max_step, start=None):
    """The path is the best, or as long as any, by brute force."""
    least = least_costs(nodes_of(robots.UR5, limits, T), max_step, start)
    path = robot.follow(T, start, max_step=max_step)
    assert_kept(robot, path, T, start)
    assert path.proof == "complete"
    assert path.ends_at == (None if np.isfinite(least[-1]) else int(np.flatnonzero(np.isinf(least))[0]))
    n = len(T) if path.ends_at is None else path.ends_at
    every = path.q[:n] if start is None else np.vstack([start, path.q[:n]])
    assert not n or (np.diff(every, axis=0) ** 2).sum() == pytest.approx(least[n - 1], rel=1e-9, abs=1e-9)
    return path


# ---- limits on one side


@pytest.mark.parametrize("sign", [1, -1])
def test_a_path_ends_at_a_limit_that_is_on_one_side_only(sign):
    limits = [(-1.0, np.inf) if sign > 0 else (-np.inf, 1.0), *[(-np.pi, np.pi)] * 5]
    robot = ur5(limits)
    known = line(Q * [sign, 1, 1, 1, 1, 1], Q * [0, 1, 1, 1, 1, 1] - [sign * 2.5, 0, 0, 0, 0, 0], 40)
    T = robot.forward_kinematics(known)
    path = robot.follow(T, known[0])
    assert_kept(robot, path, T, known[0])
    assert (path.status, path.ends_at) == ("joint limits", int(np.flatnonzero(sign * known[:, 0] < -1.0)[0]))
    least = least_costs(nodes_of(robots.UR5, [(-1, 20.0) if sign > 0 else (-20.0, 1), *limits[1:]], T), 0.1, known[0])
    assert path.ends_at == np.flatnonzero(np.isinf(least))[0]


def test_without_a_start_whole_turns_keep_a_path_within_a_limit_on_one_side():
    robot = ur5([(-1.0, np.inf), *[(-np.pi, np.pi)] * 5])
    T = robot.forward_kinematics(line(Q, [Q[0] - 3 * TURN, *Q[1:]], 300))
    path = robot.follow(T)
    assert path.success, str(path)
    assert_kept(robot, path, T)
    assert path.q[0, 0] - path.q[-1, 0] == pytest.approx(3 * TURN)


def test_away_from_its_limit_a_joint_turns_as_often_as_the_path_asks():
    robot = ur5([(-1.0, np.inf), *[(-np.pi, np.pi)] * 5])
    known = line(Q, [Q[0] + 5 * TURN, *Q[1:]], 400)
    path = robot.follow(robot.forward_kinematics(known), known[0])
    assert np.abs(path.q - known).max() < 1e-6
    assert path.proof == "complete"


def test_an_arm_of_seven_joints_keeps_a_limit_on_one_side_too():
    h = np.pi / 2
    rows = [(0, 0.34, -h, 0), (0, 0, h, 0), (0, 0.4, h, 0), (0, 0, -h, 0), (0, 0.4, -h, 0), (0, 0, h, 0), (0, 0.126, 0, 0)]
    limits = [(-1.0, np.inf), (-2, 2), (-0.3, 0.3), *[(-2, 2)] * 4]
    robot = Robot.from_dh(rows, convention="standard", limits=limits)
    begin = np.array([0.3, 0.6, 0.1, -1.2, 0.2, 0.9, 0.3])
    T = robot.forward_kinematics(line(begin, begin - [2.5, 0, 0, 0, 0, 0, 0], 40))
    path = robot.follow(T, begin)
    assert_kept(robot, path, T, begin)
    assert path.status == "joint limits"
    assert 0 < len(path.q[: path.ends_at]) < 40


# ---- limits that are whole turns apart


@pytest.mark.parametrize(
    ("limit", "seed"),  # rounding puts the last solution at the other limit
    [*[(np.pi, seed) for seed in (3, 16, 67, 81, 88)], *[(TURN, seed) for seed in (57, 58, 66, 73, 96)]],
)
def test_a_path_to_a_limit_is_followed_to_its_end(limit, seed):
    limits = [(-limit, limit)] * 6
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.5, 2.5, 6)
    q[4] = rng.uniform(0.3, 1.5)
    known = np.tile(q, (8, 1))
    known[:, [0, 1, 3, 5][seed % 4]] = (-1) ** (seed // 4) * np.linspace(limit - 0.5, limit, 8)
    robot = ur5(limits)
    assert assert_best(robot, limits, robot.forward_kinematics(known), 0.1, known[0]).success
    assert robot.follow(robot.forward_kinematics(known[::-1]), known[-1]).success


def test_two_joints_end_at_their_limits_at_once():
    limits = [(-np.pi, np.pi)] * 6
    robot = ur5(limits)
    known = line(Q, [np.pi, -1.2, 1.5, -0.7, 1.1, -np.pi], 60)
    T = robot.forward_kinematics(known)
    path = robot.follow(T, known[0])
    assert path.success, str(path)
    assert_kept(robot, path, T, known[0])
    assert np.abs(path.q - known).max() < 1e-6


# ---- steps of half a turn and more


@pytest.mark.parametrize("max_step", [3.5, 5.0, 6.3, 8.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_path_is_the_best_of_all_where_steps_are_longer_than_half_a_turn(max_step, seed):
    rng = np.random.default_rng(seed)
    limits = [(-width / 2, width / 2) for width in rng.choice([3.0, 5.0, TURN, 6.6, 9.0], 6)]
    robot = ur5(limits)
    T = robot.forward_kinematics(rng.uniform(np.maximum(robot.lower, -3.3), np.minimum(robot.upper, 3.3), (4, 6)))
    assert_best(robot, limits, T, max_step)
    assert_best(robot, limits, T, max_step, rng.uniform(robot.lower, robot.upper))


def test_a_joint_goes_the_long_way_round_if_its_limits_ask_for_it():
    limits = [(-3.3, 3.3), *[(-1.5, 1.5)] * 5]
    robot = ur5(limits)
    known = np.array([[3.2, 0.3, 1.2, 0.5, 0.9, 0.1], [-2.9, 0.4, 1.3, 0.4, 1.0, 0.2], [0.5, 0.3, 1.2, 0.5, 0.9, 0.1]])
    path = assert_best(robot, limits, robot.forward_kinematics(known), 6.2, known[0])
    assert np.abs(path.q - known).max() < 1e-6


def test_where_too_many_turns_are_possible_long_steps_prove_nothing():
    robot = ur5([(-1.4 * TURN, 1.4 * TURN)] * 6)
    known = np.array([Q, Q + 0.5])
    T = robot.forward_kinematics(known)
    path = robot.follow(T, known[0], max_step=7.0)
    assert np.abs(path.q[1] - path.q[0]).max() <= 0.5 + 1e-9
    assert path.proof == "searched"


# ---- what is said where a path ends


@pytest.mark.parametrize("seed", range(10))
def test_the_smallest_step_leads_on_and_no_smaller_one_does(seed):
    rng = np.random.default_rng(seed)
    limits = [(-width / 2, width / 2) for width in rng.choice([3.0, TURN, 9.0, 2 * TURN], 6)]
    robot = ur5(limits)
    T = robot.forward_kinematics(rng.uniform(np.maximum(robot.lower, -3.1), np.minimum(robot.upper, 3.1), (2, 6)))
    start = rng.uniform(robot.lower, robot.upper)
    path = robot.follow(T[:1], start)
    step = path.reason.data.smallest_step
    assert path.ends_at == 0
    assert robot.follow(T[:1], start, max_step=step + 1e-6).success
    assert not robot.follow(T[:1], start, max_step=step - 1e-6).success


def test_a_singular_start_far_from_all_solutions_is_not_the_reason():
    robot = ur5([(-np.pi, np.pi)] * 6)
    start = np.array([2.5, -1.2, 1.5, -0.7, 0.0, 0.4])
    T = robot.forward_kinematics(Q)[None]
    path = robot.follow(T, start)
    assert path.reason.data.smallest_step > 1.0
    assert path.reason.data.least_singular_value < 1e-2
    assert path.status == "no continuous branch"


def test_no_path_is_refused_for_a_step_that_is_allowed():
    limits = [(-3.3, 3.3), *[(-np.pi, np.pi)] * 5]
    robot = ur5(limits)
    start = np.array([3.2, *Q[1:]])
    T = robot.forward_kinematics(np.array([-2.9, *Q[1:]]))[None]
    path = robot.follow(T, start, max_step=1.0)
    least = min(np.abs(nodes - start).max(axis=1).min() for nodes in nodes_of(robots.UR5, limits, T))
    assert path.reason.data.smallest_step == pytest.approx(least, abs=1e-9)


def test_a_path_to_the_end_of_the_reach_is_followed_within_the_tolerance_and_not_proved():
    robot = ur5([(-np.pi, np.pi)] * 6)
    followed = 0
    for seed in range(12):
        q = np.random.default_rng(seed).uniform(-2, 2, 6)
        q[4] = 0.8
        known = np.tile(q, (12, 1))
        known[:, 2] = np.linspace(0.25, 0.0, 12)  # the elbow becomes straight
        T = robot.forward_kinematics(known)
        weakest = np.linalg.svd(robot.jacobian(known[-1]))[0][:, -1]
        T[-1, :3, 3] += 1e-8 * weakest[:3] / np.linalg.norm(weakest[:3])
        path = robot.follow(T, known[0])
        assert path.success, str(path)
        assert_kept(robot, path, T, known[0])
        real = robot.all_solutions(T[-1]).real.any()
        followed += path.proof == "searched"
        assert real or path.proof == "searched"
    assert followed > 0


# ---- limits where angles are known poorly


@pytest.mark.slow
@pytest.mark.parametrize("limits", [(-0.9, 0.9), (-np.pi, np.pi), (-np.pi, 3.5), (-TURN, TURN), (-4.0, 4.5)])
@pytest.mark.parametrize("wrist", [1e-3, 1e-5, 1e-6, 1e-7])
def test_a_path_along_a_limit_near_the_wrists_singularity_is_found_in_any_turn(limits, wrist, rng):
    every = np.array([(-np.pi, np.pi)] * 3 + [limits] + [(-2.0, 2.0), (-np.pi, np.pi)])
    rows = [(0.32, 0.78, -H, 0), (1.075, 0, 0, -H), (0.2, 0, -H, 0), (0, 1.1425, H, 0), (0, 0, -H, 0), (0, 0.2, 0, 0)]
    robot = Robot.from_dh(rows, convention="standard", limits=every.tolist())
    for k in range(24):
        begin = 0.4 * rng.uniform(*every.T)
        known = np.linspace(begin, begin + rng.uniform(-0.6, 0.6, 6), 8)
        known[:, 3] = np.clip(limits[k % 2] * np.linspace(0.8, 1.05, 8), *limits)
        known[:, 4] = wrist
        path = robot.follow(robot.forward_kinematics(known), known[0], max_step=1.01 * np.abs(np.diff(known, axis=0)).max())
        assert path.success, (k, str(path))
        assert (np.diff(path.q, axis=0) ** 2).sum() <= 1.001 * (np.diff(known, axis=0) ** 2).sum() + 1e-9
        assert path.proof == "complete"
