"""``robot.follow`` where no path leads on: the pose, the reason and the numbers, for paths made to end so."""

import pickle

import numpy as np
import pytest

import formulas
import robots
import ulna
from ulna import Robot
from ulna.ik.following.graph import edges_between
from ulna.ik.following.lifts import Lifts

Q = np.array([0.3, -1.2, 1.5, -0.7, 1.1, 0.4])


def ur5(limits=(np.pi,) * 6):
    return Robot.from_dh(robots.UR5, convention="standard", limits=[(-limit, limit) for limit in limits])


def turned(first, last, n=100):
    """A joint path that turns the first joint alone."""
    return Q + np.linspace(first, last, n)[:, None] * [1, 0, 0, 0, 0, 0]


def test_a_path_into_a_limit_ends_at_the_pose_beyond_it():
    robot = ur5((1.0, *[np.pi] * 5))
    known = turned(0.0, 1.2)
    T = ur5().forward_kinematics(known)
    path = robot.follow(T, known[0])
    first = int(np.flatnonzero(known[:, 0] > 1.0)[0])
    assert (path.status, path.ends_at, path.success) == ("joint limits", first, False)
    assert path.reason.data.limit_excess[0] == pytest.approx(known[first, 0] - 1.0, abs=1e-6)
    assert path.proof == "complete"
    assert np.isnan(path.q[first:]).all()
    assert np.abs(path.q[:first] - known[:first]).max() < 1e-6
    assert np.isnan(path.steps[first:]).all()
    assert "q1" in str(path.reason) or robot.joint_names[0] in str(path.reason)
    assert str(path).startswith(f"joint limits at pose {first} of 100: ")


def test_beyond_the_reach_there_is_nothing_to_follow():
    robot = ur5()
    T = np.repeat(robot.forward_kinematics(Q)[None], 60, axis=0)
    out = T[0, :3, 3] / np.linalg.norm(T[0, :3, 3])
    T[:, :3, 3] += np.linspace(0, 1.5, 60)[:, None] * out
    path = robot.follow(T, max_step=3.0)
    real = robot.all_solutions(T).real.any(axis=1)
    assert (path.status, path.ends_at) == ("unreachable", int(np.flatnonzero(~real)[0]))
    assert path.proof == "complete"


def test_a_first_pose_out_of_reach_is_refused_at_once(panda):
    T = np.repeat(ulna.pose((3.0, 0, 0))[None], 3, axis=0)
    path = panda.follow(T)
    assert (path.status, path.ends_at) == ("unreachable", 0)
    assert "arm spans" in str(path.reason)
    assert np.isnan(path.q).all()


def test_a_start_too_far_away_says_how_far():
    robot = ur5()
    T = robot.forward_kinematics(turned(0, 0.1, 5))
    path = robot.follow(T, Q + np.array([0.4, 0, 0, 0, 0, 0]))
    assert (path.status, path.ends_at) == ("no continuous branch", 0)
    assert path.reason.data.smallest_step == pytest.approx(0.4, abs=1e-6)
    assert robot.follow(T, Q + np.array([0.4, 0, 0, 0, 0, 0]), max_step=0.41).success


def test_a_start_beyond_the_limits_is_named_if_it_is_too_far_from_the_first_pose():
    robot = ur5((0.3, *[np.pi] * 5))
    T = robot.forward_kinematics(turned(-0.3, -0.1, 5))
    path = robot.follow(T, Q + np.array([0.5, 0, 0, 0, 0, 0]))
    assert (path.status, path.ends_at) == ("joint limits", 0)
    assert path.reason.data.limit_excess[0] == pytest.approx(0.5)
    assert str(path.reason).startswith("q_start is beyond the limits of joint1 by 0.5; from the nearest")
    assert "a step of 0.3 away" in str(path.reason)
    assert robot.follow(T, Q + np.array([0.5, 0, 0, 0, 0, 0]), max_step=0.31).success


def test_poses_too_far_apart_say_which_step_would_do():
    robot = ur5()
    T = robot.forward_kinematics(turned(0, 1.0, 6))
    path = robot.follow(T)
    assert (path.status, path.ends_at) == ("no continuous branch", 1)
    assert path.reason.data.alive == 8
    assert path.reason.data.smallest_step == pytest.approx(0.2, abs=1e-6)
    assert robot.follow(T, max_step=0.21).success


def test_a_path_that_just_misses_a_singular_wrist_is_refused_for_it():
    robot = ur5()
    known = Q + np.linspace(-0.5, 0.5, 61)[:, None] * [0, 0, 0, 0, 1.0, 0]
    known[:, 4] -= Q[4]
    through = robot.forward_kinematics(known)
    axis = robot.jacobian(known[30])[3:, 4]  # of the fifth joint
    T = through.copy()
    T[:, :3, :3] = formulas.rotation(np.cross(through[30, :3, 2], axis), 0.02) @ through[:, :3, :3]
    free = robot.follow(T, known[0], max_step=3.0)
    assert free.success
    assert free.steps.max() > 0.3
    assert robot.follow(through, known[0]).success
    path = robot.follow(T, known[0])
    assert path.status == "singular"
    assert 20 < path.ends_at < 35
    assert path.reason.data.least_singular_value < 0.05
    assert path.reason.data.smallest_step > 0.1


def test_a_box_in_the_way_ends_the_path_with_its_name_and_depth(panda):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.5, 0.2, 0.5)))
    T = np.repeat(panda.forward_kinematics(panda.home)[None], 60, axis=0)
    T[:, :3, 3] = [0.45, 0.0, 0.5]
    T[:, 1, 3] = np.linspace(-0.3, 0.4, 60)
    assert panda.follow(T).success
    path = panda.follow(T, world=world)
    assert path.status == "in collision"
    assert "crate" in {name for pair in path.reason.data.collisions for name in pair[:2]}
    assert path.reason.data.collisions[0][2] > 0.0
    q = path.q[: path.ends_at]
    assert not panda.in_collision(q, world).any()
    assert not panda.edge_in_collision(q[:-1], q[1:], world).in_collision.any()


def test_a_world_chooses_the_branch_that_is_clear(panda):
    known = panda.home + np.linspace(0, 0.4, 30)[:, None] * [1, 0.2, -0.3, 0.4, 0, 0.2, 0]
    T = panda.forward_kinematics(known)
    elbow = panda.link_poses(panda.follow(T).q[15])[4, :3, 3]
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.06), ulna.pose(elbow + np.array([0, 0, 0.12])))
    path = panda.follow(T, world=world)
    assert path.success, str(path)
    assert not panda.in_collision(path.q, world).any()
    assert not panda.edge_in_collision(path.q[:-1], path.q[1:], world).in_collision.any()


def test_a_result_may_be_pickled_and_not_be_changed():
    robot = ur5()
    path = robot.follow(robot.forward_kinematics(turned(0, 0.2, 10)))
    again = pickle.loads(pickle.dumps(path))  # noqa: S301
    assert np.array_equal(again.q, path.q)
    assert str(again) == str(path)
    with pytest.raises(ValueError, match="read-only"):
        path.q[0] = 0


def apart_in_the_middle(panda, n=12):
    """Poses between which the hand jumps by 0.4 m."""
    T = panda.forward_kinematics(panda.home + np.linspace(0, 0.4, n)[:, None] * [1, 0.3, 0.2, 0.4, 0.3, 0.2, 0.1])
    T[n // 2 :, :3, 3] += [0.0, -0.3, 0.25]
    return T


@pytest.mark.parametrize("task", ["pose", "pointing", "position", ulna.Task((0.01, 0.01, 0.01, 0.1, 0.1, 0.1))])
def test_a_search_ends_when_its_time_is_over_and_says_so(panda, task):
    T = apart_in_the_middle(panda)
    path = panda.follow(T, task=task, time_limit=1e-9)
    assert (path.status, path.proof, bool(path)) == ("budget spent", "searched", False)
    assert "time_limit=1e-09 was over" in str(path.reason)
    assert np.isnan(path.q[path.ends_at :]).all()
    whole, unlimited = panda.follow(T, task=task), panda.follow(T, task=task, time_limit=np.inf)
    assert (whole.status, whole.ends_at) == ("no continuous branch", 6)
    assert np.array_equal(whole.q, unlimited.q, equal_nan=True)


@pytest.mark.parametrize("arm", ["panda", "ur5"])
def test_whenever_the_time_is_over_what_is_returned_is_a_path_so_far(panda, arm, monkeypatch):
    robot, world = (panda, ulna.World()) if arm == "panda" else (ur5(), None)
    T = robot.forward_kinematics(robot.home + np.linspace(0, 0.3, 15)[:, None] * np.ones(robot.n_dof))
    if world is not None:
        world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose(xyz=(0.2, 0.6, 0.3)))
    asked, endings = [0], set()
    for last in (0, 1, 2, 3, 5, 8, 12, 18, 30, 50, 10_000):
        asked[0] = 0

        def is_over(_, last=last):
            asked[0] += 1
            return asked[0] > last

        monkeypatch.setattr("ulna.ik.time_limit.TimeLimit.is_over", is_over)
        path = robot.follow(T, world=world, time_limit=1.0)
        endings.add(str(path.status))
        q = path.q[: path.ends_at]
        assert path.status in {"followed", "budget spent"}
        assert np.allclose(robot.forward_kinematics(q), T[: len(q)], atol=1e-4)
        assert np.abs(np.diff(q, axis=0)).max(initial=0.0) <= 0.1
        assert world is None or not np.any(robot.in_collision(q, world))
    assert endings == {"followed", "budget spent"}


@pytest.mark.parametrize("limit", [0, -1, np.nan, "5", True])
def test_a_time_that_is_none_is_refused_by_name(panda, limit):
    with pytest.raises(ulna.InputError, match="time_limit"):
        panda.follow(apart_in_the_middle(panda), time_limit=limit)


@pytest.mark.parametrize("longest", [1e-3, 0.05, 0.6, 3.1])
@pytest.mark.parametrize("wide", [0.2, 2.0, 9.0, np.inf])
def test_the_edges_of_two_layers_are_those_of_all_pairs(wide, longest, rng):
    limits = np.array([wide, 0.1, 1.0])
    lifts = Lifts.make(-limits, limits, np.array([True, False, True]), np.zeros(3), one_sided=False)
    a, b = (lifts.first_turn(rng.uniform(-np.minimum(limits, 50), np.minimum(limits, 50), (n, 3))) for n in (300, 200))
    b[:50] = a[:50] + rng.normal(scale=longest / 2, size=(50, 3))
    edges = edges_between(lifts, a, b, longest, 1.0)
    difference = b[:, None] - a[None]
    turned = np.where(lifts.lifted | lifts.free, difference - 2 * np.pi * np.rint(difference / (2 * np.pi)), difference)
    end, begin = np.nonzero(np.abs(turned).max(axis=-1) <= longest)
    assert len(end)
    assert np.array_equal(edges.begin, begin)
    assert np.array_equal(edges.end, end)
    assert np.allclose(edges.cost, (turned[end, begin] ** 2).sum(axis=-1))
    assert not len(edges_between(lifts, a[:0], b, longest, 1.0).begin) + len(edges_between(lifts, a, b[:0], longest, 1.0).begin)
