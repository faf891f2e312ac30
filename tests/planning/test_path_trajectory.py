"""Configurations that a caller has become a motion that stays near the lines between them, within all limits."""

from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.errors import InputError


def curve(robot, n, width=0.5):
    return robot.home + width * np.sin(np.linspace(0, 1, n)[:, None] * np.arange(1, 8))


def corners(panda, n=6):
    """Corners, of which some have joints at the ends of their ranges."""
    return np.clip(np.cumsum(np.random.default_rng(0).normal(size=(n, 7)) * 0.3, axis=0), panda.lower, panda.upper)


def distance(points, q):
    """How far each q is at least from the lines between points, in the joint of the greatest difference, shape (len(q),).

    The difference is convex along a line, so that it is found by thirds.
    """
    least = np.full(len(q), np.inf)
    for a, b in pairwise(points):
        low, high = np.zeros(len(q)), np.ones(len(q))
        for _ in range(60):
            first, second = low + (high - low) / 3, high - (high - low) / 3
            at = [np.abs(q - a - t[:, None] * (b - a)).max(axis=1) for t in (first, second)]
            low, high = np.where(at[0] > at[1], first, low), np.where(at[0] > at[1], high, second)
        least = np.minimum(least, np.abs(q - a - (0.5 * (low + high))[:, None] * (b - a)).max(axis=1))
    return least


@pytest.mark.slow
@pytest.mark.parametrize("within", [0.1, 0.01, 1e-4])
@pytest.mark.parametrize("options", [{"limits": "franka"}, {"acceleration": 5, "jerk": 50}, {"acceleration": 15}])
@pytest.mark.parametrize("shape", ["curve", "corners"])
def test_it_stays_within_its_bound_of_the_lines_and_within_its_limits(panda, within, options, shape):
    points = curve(panda, 30) if shape == "curve" else corners(panda)
    motion = panda.trajectory(points, within=within, **options)
    moment = motion.at(np.linspace(0, motion.duration, 20_001))
    assert distance(points, moment.q[::10]).max() <= within * (1 + 1e-9)
    assert motion.stops == 0
    assert not motion.certified
    assert np.allclose(motion.q[[0, -1]], points[[0, -1]], atol=1e-12)
    for rates, most in zip(moment[1:], motion._limits, strict=True):
        assert most is None or (np.abs(rates) <= most * (1 + 1e-9)).all()
    for period in (1e-3, 1e-4):
        assert motion.check(period=period)


def test_with_more_room_it_is_faster_and_near_the_bound(panda):
    durations = [panda.trajectory(corners(panda), within=within, limits="franka").duration for within in (0.1, 0.01, 1e-3)]
    assert durations == sorted(durations)
    close = panda.trajectory(corners(panda), within=1e-3, acceleration=15.0)
    assert distance(corners(panda), close.at(np.linspace(0, close.duration, 20_001)).q).max() > 0.5e-3


def test_many_points_of_a_curve_take_as_long_as_few(panda):
    few, many = (panda.trajectory(curve(panda, n), limits="franka") for n in (50, 1000))
    assert many.stops == 0
    assert many.duration == pytest.approx(few.duration, rel=0.02)
    assert many.check()


def test_what_follow_returns_is_timed_from_its_start_on(panda):
    T = np.repeat(panda.forward_kinematics(panda.home)[None], 40, axis=0)
    T[:, 1, 3] += np.linspace(0, 0.2, 40)
    path = panda.follow(T, panda.home)
    assert path
    motion = panda.trajectory(path, within=1e-3, limits="franka")
    assert np.array_equal(motion.q[0], panda.home)
    assert np.allclose(motion.q[-1], path.q[-1], atol=1e-12)
    assert motion.check()
    T[20:, 1, 3] += 9.0
    with pytest.raises(InputError, match="q_path: not followed to its end: unreachable at pose 20"):
        panda.trajectory(panda.follow(T, panda.home), limits="franka")


def test_with_a_world_it_is_certified_or_says_that_it_is_not(panda):
    world = ulna.World()
    world.add("far", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((2.0, 0.0, 0.5)))
    points = curve(panda, 12, 0.2)
    free = panda.trajectory(points, world=world, limits="franka")
    assert free.certified
    assert free.is_free(world)
    world.add("there", ulna.Box((0.1, 0.1, 0.1)), panda.forward_kinematics(points[6]))
    assert not panda.trajectory(points, world=world, limits="franka").certified
    assert free.certified


def test_points_on_a_line_and_equal_points_are_passed_without_a_stop(panda):
    line = panda.home + np.linspace(0, 1, 500)[:, None] * np.full(7, 0.3)
    ends = panda.trajectory(line[[0, -1]], limits="franka")
    twice = np.repeat(line, 2, axis=0)
    for points in (line, twice, np.vstack([line, line[-1:] + 1e-10])):
        motion = panda.trajectory(points, limits="franka")
        assert motion.stops == 0
        assert motion.duration == pytest.approx(ends.duration, rel=1e-6)
    back = panda.trajectory(np.vstack([line, line[::-1]]), limits="franka")
    assert back.check()
    assert np.allclose(back.q[-1], line[0], atol=1e-12)


def test_a_path_of_one_point_or_of_equal_points_does_not_move(panda):
    for points in (panda.home[None], np.repeat(panda.home[None], 5, axis=0)):
        motion = panda.trajectory(points, limits="franka")
        assert motion.duration == 0
        assert np.array_equal(motion.sampled().q, panda.home[None])
    free = panda.trajectory(panda.home[None], limits="franka", world=ulna.World())
    assert free.certified


def test_a_path_of_a_few_billionths_is_timed_too(panda):
    points = (
        panda.home + np.array([0.0, 3e-9, 9e-9])[:, None] * np.array([[1, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0, 0]])[[0, 0, 1]]
    )
    for options in ({"limits": "franka"}, {"acceleration": 5.0}):
        motion = panda.trajectory(points, **options)
        assert 0 < motion.duration < 0.01
        assert np.array_equal(motion.q[0], points[0])
        assert np.allclose(motion.q[-1], points[-1], atol=1e-15)


def test_slides_and_joints_without_limits_are_timed_and_one_that_may_not_move_is_named():
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="lift" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="0" upper="1" velocity="{}" effort="1"/></joint>
      <joint name="turn" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint></robot>"""
    points = np.array([[0.0, 0.0], [0.5, 1.0], [0.5, 9.0]])
    motion = ulna.load(text.format(0.2)).trajectory(points, acceleration=[1.0, 20.0], jerk=100.0)
    assert motion.check()
    assert np.abs(motion.at(np.linspace(0, motion.duration, 5001)).qd[:, 0]).max() <= 0.2
    still = ulna.load(text.format(0))
    with pytest.raises(InputError, match=r"velocity: the description allows 'lift' a velocity of 0.*give velocity="):
        still.trajectory(points, acceleration=1.0)
    assert still.trajectory(points, acceleration=1.0, velocity=1.0).duration > 0


@pytest.mark.parametrize(
    ("points", "options", "argument"),
    [
        (np.zeros((0, 7)), {}, "q_path: shape"),
        (np.zeros(7), {}, "q_path: shape"),
        (np.zeros((3, 6)), {}, "q_path: shape"),
        (np.full((3, 7), np.nan), {}, r"q_path.*not a finite number"),
        ("home", {}, "q_path"),
        (np.zeros((2, 7)), {"within": 0.0}, "within"),
        (np.zeros((2, 7)), {"within": np.inf}, "within"),
        (np.zeros((2, 7)), {"jerk": -1.0}, "jerk"),
        (np.zeros((2, 7)), {"world": 3}, "world: int"),
    ],
)
def test_what_cannot_be_taken_is_refused_by_name(panda, points, options, argument):
    with pytest.raises(InputError, match=argument):
        panda.trajectory(points, limits="franka", **options)
    with pytest.raises(InputError, match="acceleration: none is given"):
        panda.trajectory(np.zeros((2, 7)))


@pytest.mark.parametrize("beyond", [1e-8, 0.2])
def test_a_path_beyond_a_limit_of_position_is_refused_with_its_joint_and_amount(panda, beyond):
    points = np.stack([panda.home, panda.home, panda.home])
    points[1, 3] = panda.upper[3] + beyond
    with pytest.raises(
        InputError, match=rf"q_path: point 1 has panda_joint4 at .*, {beyond:.3g} beyond its upper limit of -0.0698"
    ):
        panda.trajectory(points, limits="franka")
    points[1, 3] = panda.upper[3] + 1e-10  # which inverse kinematics takes for the limit
    motion = panda.trajectory(points, limits="franka")
    assert motion.check()
    assert (motion.at(np.linspace(0, motion.duration, 1001)).q <= panda.upper).all()


def test_two_motions_one_after_the_other_are_each_of_them_with_a_stop_between(panda):
    world = ulna.World()
    there, away = panda.home + 0.3, panda.home - 0.2
    first = panda.plan(panda.home, there, world).trajectory(acceleration=3.0, jerk=30.0)
    second = panda.plan(there, away, world).trajectory(acceleration=5.0)
    both = first.then(second)
    assert both.certified
    assert both.stops == first.stops + second.stops + 1
    assert both.duration == first.duration + second.duration
    t = np.linspace(0.0, both.duration, 400)
    early = t < first.duration
    np.testing.assert_allclose(both.at(t[early]).q, first.at(t[early]).q, atol=1e-12)
    np.testing.assert_allclose(both.at(t[~early]).q, second.at(t[~early] - first.duration).q, atol=1e-12)
    assert both.check()
    assert not both.limits_jerk
    assert not both.check(jerk=30.0)
    np.testing.assert_array_equal(both.limits["acceleration"][1], second.limits["acceleration"][1])
    assert both.is_free(world)
    with pytest.raises(InputError, match="its start differs from the end"):
        first.then(first)
    with pytest.raises(InputError, match="a motion of the same joints"):
        first.then(None)
    moving = panda.plan(there, away, world).trajectory(acceleration=5.0, start_velocity=0.01 * (away - there))
    with pytest.raises(InputError, match="at rest where they are joined"):
        first.then(moving)
    still = panda.plan(there, there, world).trajectory(acceleration=5.0)
    assert first.then(still) is first
    assert panda.trajectory([panda.home], acceleration=5.0).then(first) is first
