"""Random configurations: within the limits, finite where there are none, and the same for the same seed."""

import numpy as np
import pytest

import robots
import ulna
from robot_files import example_urdfs, of_kinds
from ulna.description.robot_description import Limits

NOT_LOADED = {"alex_psyonic_hands", "ur3"}  # tests/crosscheck has the reasons


def test_one_configuration_and_many_are_within_the_limits_and_fill_them(panda):
    q = panda.random(4000, seed=1)
    assert (q.shape, panda.random(seed=1).shape, panda.random(0).shape) == ((4000, 7), (7,), (0, 7))
    assert ((q >= panda.lower) & (q <= panda.upper)).all()
    np.testing.assert_allclose(q.min(axis=0), panda.lower, atol=0.01)
    np.testing.assert_allclose(q.max(axis=0), panda.upper, atol=0.01)
    np.testing.assert_array_equal(panda.random(seed=1), q[0])
    np.testing.assert_array_equal(panda.random(4000, seed=1), q)
    np.testing.assert_array_equal(panda.random(4000, seed=np.random.default_rng(1)), q)
    assert not np.array_equal(panda.random(5), panda.random(5))


FILES = [file for file in example_urdfs() if file.stem not in NOT_LOADED]


@pytest.mark.parametrize("file", of_kinds(FILES), ids=lambda file: file.stem)
def test_every_robot_can_stand_at_random(file):
    robot = ulna.load(file)
    q = robot.random(20, seed=0)
    assert np.isfinite(robot.link_poses(q)).all()
    assert ((q >= robot.lower) & (q <= robot.upper)).all()


def test_an_angle_without_limits_is_within_half_a_turn():
    robot = ulna.Robot(robots.of_chain("continuous", "continuous"))
    q = robot.random(4000, seed=0)
    np.testing.assert_allclose([q.min(axis=0), q.max(axis=0)], [[-np.pi] * 2, [np.pi] * 2], atol=0.01)


def test_a_slide_without_limits_is_within_the_robots_length():
    T = np.eye(4)
    T[0, 3] = 0.7
    robot = ulna.Robot(robots.of_chain("revolute", "prismatic", "revolute", origin=T))  # three parts of 0.7 m
    slides = robot.random(4000, seed=0)[:, 1]
    np.testing.assert_allclose([slides.min(), slides.max()], [-2.1, 2.1], atol=0.01)
    alone = ulna.Robot(robots.of_chain("prismatic")).random(4000, seed=0)
    np.testing.assert_allclose([alone.min(), alone.max()], [-1, 1], atol=0.01)


@pytest.mark.parametrize(("limits", "range_"), [((-1e308, 1e308), (-1, 1)), ((-2e3, 1e4), (-2e3, 1e4)), ((3, 1e16), (3, 5))])
def test_a_limit_too_wide_to_count_is_ignored(limits, range_):
    robot = ulna.Robot(robots.two_links("prismatic", robots.X, limits=Limits(*limits, 1.0)))
    q = robot.random(4000, seed=0)
    np.testing.assert_allclose([q.min(), q.max()], range_, atol=1e-2 * (range_[1] - range_[0]))


def test_a_robot_without_joints_has_an_empty_random_q():
    robot = ulna.load("panda", base="panda_link7", tip="panda_link8")
    assert (robot.random().shape, robot.random(3).shape) == ((0,), (3, 0))


@pytest.mark.parametrize("n", [-1, 1.5, True, "3", (2, 3)])
def test_what_is_no_count_is_refused(panda, n):
    with pytest.raises(ulna.InputError, match="n: "):
        panda.random(n)


@pytest.mark.parametrize("seed", [-1, "a", 1.5])
def test_what_is_no_seed_is_refused(panda, seed):
    with pytest.raises(ulna.InputError, match="seed: "):
        panda.random(seed=seed)
