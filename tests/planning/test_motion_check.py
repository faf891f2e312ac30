"""A motion is judged by differences of the samples that a controller gets."""

from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.errors import InputError, UnknownNameError
from ulna.planning.arm_limits import ARMS


def worst_share(samples, period, limits):
    """The greatest share of a limit, by differences taken one after the other, from and to rest."""
    q = [samples.q[0]] * 3 + list(samples.q) + [samples.q[-1]] * 3
    v, a, worst = np.zeros(len(q[0])), np.zeros(len(q[0])), 0.0
    for before, now in pairwise(q):
        velocity = (now - before) / period
        acceleration = (velocity - v) / period
        jerk = (acceleration - a) / period
        for value, limit in zip((velocity, acceleration, jerk), limits, strict=True):
            worst = max(worst, (np.abs(value) / limit).max())
        v, a = velocity, acceleration
    return worst


def test_samples_are_evenly_spaced_and_end_exactly_at_rest_where_the_motion_ends(plan):
    motion = plan.trajectory(limits="franka")
    for period in (0.001, 0.01, 0.37):
        samples = motion.sampled(period)
        assert np.allclose(np.diff(samples.t), period, rtol=1e-9)
        assert samples.t[0] == 0
        assert motion.duration <= samples.t[-1] < motion.duration + period
        assert np.array_equal(samples.q[-1], motion.q[-1])
        assert not samples.qd[-1].any()
        assert not samples.qdd[-1].any()
        assert np.array_equal(samples.q[:-1], motion.at(samples.t[:-1]).q)


@pytest.mark.parametrize("period", [1e-3, 1e-4])
@pytest.mark.parametrize("blend", [0.0, 0.1])
def test_a_motion_within_the_limits_of_a_franka_is_accepted_and_one_without_jerk_is_not(plan, period, blend):
    limits = ARMS["panda"]
    motion = plan.trajectory(limits="franka", blend=blend)
    check = motion.check("franka", period=period)
    assert check
    assert str(check).startswith("within the limits")
    share = worst_share(motion.sampled(period), period, (limits.velocity, limits.acceleration, limits.jerk))
    assert share == pytest.approx(check.value / check.limit, rel=1e-5)
    assert share <= 1 + 1e-5

    sudden = plan.trajectory(acceleration=limits.acceleration, blend=blend)
    check = sudden.check("franka", period=period)
    assert not check
    assert check.quantity == "jerk"
    assert check.joint in sudden.joint_names
    share = worst_share(sudden.sampled(period), period, (limits.velocity, limits.acceleration, limits.jerk))
    assert check.value / check.limit == pytest.approx(share, rel=1e-5)
    assert share > 1.1
    assert str(check).startswith("beyond a limit: the jerk of panda_joint")
    assert 0 <= check.time <= sudden.duration + 4 * period


def test_what_is_given_counts_before_what_is_named_and_the_motions_own_limits_serve(plan):
    motion = plan.trajectory(acceleration=5.0, jerk=500.0)
    assert motion.check()
    assert motion.check("franka")
    assert not motion.check(jerk=400.0)
    assert not motion.check("franka", acceleration=4.0)
    check = motion.check(velocity=0.5)
    assert (check.within, check.quantity, check.limit) == (False, "velocity", 0.5)
    assert motion.check(velocity=np.inf, acceleration=6.0)


def test_the_velocities_of_an_fr3_depend_on_how_near_a_joint_is_to_its_end(panda):
    start, goal = panda.home.copy(), panda.home.copy()
    start[0], goal[0] = 0.0, 2.74
    plan = panda.plan(start, goal)
    fast = plan.trajectory(limits="fr3", velocity=2.6, jerk=4000.0)
    check = fast.check("fr3")
    assert not check
    assert check.quantity == "velocity"
    assert np.isclose(check.limit, np.sqrt(12.0 * (2.7501 - fast.at(check.time).q[0])) - 0.301, atol=5e-3)
    slow = plan.trajectory(limits="fr3").slowed(0.05)
    assert slow.check("fr3")
    away = panda.plan(panda.home, start + 0.1).trajectory(limits="fr3")
    assert away.check("fr3")


def test_a_slower_motion_passes_the_same_configurations(plan):
    for options in ({"acceleration": 5.0}, {"limits": "franka"}, {"limits": "franka", "blend": 0.0}):
        motion = plan.trajectory(**options)
        slow = motion.slowed(0.5)
        t = np.linspace(0, motion.duration, 1001)
        fast, late = motion.at(t), slow.at(t / 0.5)
        assert slow.duration == pytest.approx(2 * motion.duration, rel=1e-12)
        assert np.allclose(late.q, fast.q, atol=1e-12)
        assert np.allclose(late.qd, 0.5 * fast.qd, atol=1e-9)
        inside = np.abs(t[:, None] - motion.times).min(axis=1) > 1e-6  # the acceleration may jump at grid points
        assert np.allclose(late.qdd[inside], 0.25 * fast.qdd[inside], atol=1e-6)
        assert np.allclose(late.jerk[inside], 0.125 * fast.jerk[inside], atol=1e-3)
        assert slow.certified
        assert slow.is_free(plan._motion.world)
        assert slow.check()
        assert slow.stops == motion.stops
    assert motion.slowed(1.0).duration == motion.duration


def test_a_motion_that_does_not_move_has_one_sample(panda):
    motion = panda.plan(panda.home, panda.home).trajectory(limits="franka")
    assert motion.check()
    assert motion.sampled().q.shape == (1, 7)
    assert motion.slowed(0.5).duration == 0


def test_what_cannot_be_taken_is_refused_by_name(panda, plan):
    motion = plan.trajectory(acceleration=5.0)
    for call, argument in (
        (lambda: motion.sampled(0.0), "period"),
        (lambda: motion.sampled(1e-9), "period"),
        (lambda: motion.check(period=-1.0), "period"),
        (lambda: motion.check(acceleration=0.0), "acceleration"),
        (lambda: motion.check(7), "limits"),
        (lambda: motion.check("ur5e"), "limits: ur5e has 6 joints, the robot has 7"),
        (lambda: motion.slowed(0.0), "factor"),
        (lambda: motion.slowed(1.5), "factor"),
        (plan.trajectory, "acceleration: none is given"),
        (lambda: plan.trajectory(limits="iiwa14"), "acceleration: iiwa14 has none"),
    ):
        with pytest.raises(InputError, match=argument):
            call()
    with pytest.raises(UnknownNameError, match=r"franca.*franka"):
        plan.trajectory(limits="franca")
    assert plan.trajectory(limits="iiwa14", acceleration=3.0).check("iiwa14")


@pytest.mark.parametrize("name", ARMS)
def test_every_set_has_a_source_and_a_limit_above_zero_of_each_joint(name):
    arm = ARMS[name]
    assert arm.source
    for limits in (arm.velocity, arm.acceleration, arm.jerk):
        assert limits is None or (limits.shape == arm.velocity.shape and (limits > 0).all())


def test_franka_is_the_fr3_where_the_joints_are_called_so(panda):
    text = panda.to_urdf().replace("panda", "fr3")
    robot = ulna.load(text)
    goal = robot.home.copy()
    goal[0] += 0.5
    motion = robot.plan(robot.home, goal).trajectory(limits="franka")
    assert motion._limits.acceleration.tolist() == [10.0] * 7
    assert motion.check("fr3")


def test_a_motion_of_many_points_takes_as_long_for_each_as_one_of_few_and_keeps_its_limits_for_minutes(panda):
    points = panda.home + 0.2 * np.random.default_rng(0).normal(size=(500, 7))
    few, many = (panda.trajectory(points[:n], limits="franka") for n in (50, 500))
    assert many.duration < 12.0 * few.duration
    assert many.duration > 100.0
    assert many.check()
    assert not many.check(acceleration=7.4)


def test_positions_are_compared_between_samples_too(panda):
    """A joint that turns round between two samples a second apart, and so does a mean of it: the peak is found."""
    points = np.stack([panda.home, panda.home, panda.home])
    points[1, 0] = 1.0
    for options in ({"acceleration": 2.0}, {"acceleration": 2.0, "jerk": 50.0}, {"limits": "franka"}):
        motion = panda.trajectory(points, within=0.05, **options)
        q = motion.at(np.linspace(0, motion.duration, 200_001)).q
        peak = int(q[:, 0].argmax())
        for limit, within in ((q[peak, 0] + 1e-8, True), (q[peak, 0] - 1e-8, False)):
            check = motion.check({"joint_limits": {"panda_joint1": {"max_position": float(limit)}}}, period=motion.duration)
            assert check.within is within
            if not within:
                assert (check.joint, check.quantity, check.limit) == ("panda_joint1", "position", limit)
                assert check.value == pytest.approx(q[peak, 0], abs=1e-9)
                assert check.time == pytest.approx(motion.duration * peak / 200_000, abs=1e-4)
                assert "the position of panda_joint1 is " in str(check)
                assert "beyond its upper limit of" in str(check)


def test_the_farthest_of_a_replaced_motion_is_that_of_a_dense_one(panda):
    left, right = panda.home.copy(), panda.home.copy()
    left[:2], right[:2] = (0.5, -0.2), (-0.5, -0.2)
    for options in ({"acceleration": 3.0}, {"acceleration": 3.0, "jerk": 30.0}):
        motion = panda.plan(left, right).trajectory(**options)
        t = 0.4 * motion.duration
        motion = motion.replace(panda.plan(motion.at(t).q, panda.home), at=t)
        q = motion.at(np.linspace(t, motion.duration, 100_001)).q
        found = motion._timed.farthest(t)
        for exact, dense in zip(found.q, (q.min(axis=0), q.max(axis=0)), strict=True):
            assert np.allclose(exact, dense, rtol=0, atol=1e-8)
        assert (found.q[0] <= q.min(axis=0) + 1e-13).all()
        assert (found.q[1] >= q.max(axis=0) - 1e-13).all()
        at = motion.at(found.times.ravel()).q.reshape(2, 7, 7)[:, range(7), range(7)]
        assert np.allclose(at, found.q, rtol=0, atol=1e-10)


@pytest.mark.parametrize(("velocity", "acceleration", "jerk"), [(0.02, 0.05, 50.0), (0.01, 0.02, 500.0)])
def test_a_slow_motion_with_little_jerk_keeps_its_own_limits(panda, velocity, acceleration, jerk):
    """The mean of it is over some 1e-4 s of minutes: it is found without losing digits."""
    path = panda.home + 0.4 * np.sin(np.linspace(0, 9, 60))[:, None] * np.array([1, 0.5, 0.3, 0.2, 0.1, 0.4, 1])
    motion = panda.trajectory(path, within=0.001, velocity=velocity, acceleration=acceleration, jerk=jerk)
    assert motion.check()
    sampled = motion.sampled(0.001)
    assert np.abs(np.diff(sampled.q, 2, axis=0)).max() <= acceleration * 1e-6 * (1 + 1e-6)


def test_a_little_beyond_a_limit_is_told_in_numbers_that_differ(panda):
    motion = panda.trajectory([panda.home, panda.home + 0.3], acceleration=2.0)
    for much, says in ((1 + 2e-6, "0.0002 % above its limit of"), (1.05, "5 % above its limit of"), (1.5, "1.5 times its limit")):
        check = motion.check(acceleration=2.0 / much)
        assert not check
        assert says in str(check)
        assert ", 1 times" not in str(check)
