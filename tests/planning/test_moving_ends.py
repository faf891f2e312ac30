"""Motions that move at their start or at their end: those velocities, all limits at all times, free, or a named error."""

from itertools import pairwise

import numpy as np
import pytest

import ulna
from ulna.arms import Recorder
from ulna.errors import InputError

FRANKA = {"limits": "franka"}
SLOW = {"acceleration": 5.0, "jerk": 50.0}
SUDDEN = {"acceleration": 5.0}
LIMITS = [FRANKA, SLOW, SUDDEN]


def judge(motion, start, end):
    """Velocities at the ends, and all limits by derivatives and by differences of what a controller is sent."""
    assert np.allclose(motion.at(0.0).qd, start, atol=1e-9)
    assert np.allclose(motion.at(motion.duration).qd, end, atol=1e-9)
    assert np.array_equal(motion.end_velocities, [start, end])
    if motion._limits.jerk is not None:
        assert np.abs(motion.at([0.0, motion.duration]).qdd).max() < 1e-9
    moments = np.linspace(-0.01, motion.duration + 0.01, 20_001)
    moment, h = motion.at(moments), moments[1] - moments[0]
    for (values, rates), most in zip(pairwise(moment), motion._limits, strict=False):
        if most is not None:
            assert (np.abs(rates) <= most * (1 + 1e-9)).all()
            assert (np.abs(np.diff(values, axis=0)) <= most * h * (1 + 1e-6) + 1e-12).all()
    for period in (1e-3, 1e-4):
        assert motion.check(period=period)


@pytest.mark.parametrize("options", LIMITS)
def test_a_line_is_passed_with_velocities_along_it(panda, options):
    end = panda.home + np.linspace(0.2, 1.0, 7) * [1, 1, -1, 1, 1, -1, 1]
    slope = (end - panda.home) / np.linalg.norm(end - panda.home)
    for first, last in ((0.5, 0.0), (0.0, 0.5), (0.4, 0.7)):
        velocities = first * slope, last * slope
        motion = panda.plan(panda.home, end).trajectory(start_velocity=velocities[0], end_velocity=velocities[1], **options)
        judge(motion, *velocities)
        assert np.allclose(motion.q[[0, -1]], [panda.home, end], atol=1e-12)
        assert motion.certified
    assert motion.duration < panda.plan(panda.home, end).trajectory(**options).duration


@pytest.mark.parametrize(("speed", "most", "length"), [(0.5, 2.0, 3.0), (1.5, 2.0, 3.0), (1.0, 1.0, 0.5)])
def test_a_line_from_a_speed_takes_the_time_of_a_trapezoid(speed, most, length):
    """Without jerk: t = (v - s) / a + cruise / v + v / a."""
    robot = ulna.load(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="prismatic"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/><limit lower="-9" upper="9" velocity="9" effort="1"/></joint></robot>'
    )
    a = 2.0
    peak = min(most, np.sqrt(a * length + speed**2 / 2))
    cruise = length - (2 * peak**2 - speed**2) / (2 * a)
    expected = (peak - speed) / a + cruise / peak + peak / a
    for name, points in (("start_velocity", [[0.0], [length]]), ("end_velocity", [[0.0], [length]])):
        motion = robot.trajectory(points, velocity=most, acceleration=a, **{name: [speed]})
        assert motion.duration == pytest.approx(expected, rel=2e-3)
        smooth = robot.trajectory(points, velocity=most, acceleration=a, jerk=400.0, **{name: [speed]})
        assert expected < smooth.duration < expected + 0.02


@pytest.mark.parametrize("options", LIMITS)
def test_a_velocity_beside_the_path_goes_straight_on_and_turns_into_it(panda, world, plan, options):
    rng = np.random.default_rng(3)
    made = 0
    for _ in range(8):
        start, end = 0.3 * rng.normal(size=(2, 7))
        try:
            motion = plan.trajectory(start_velocity=start, end_velocity=end, **options)
        except InputError:
            continue
        made += 1
        judge(motion, start, end)
        assert np.allclose(motion.q[[0, -1]], plan.path[[0, -1]], atol=1e-12)
        assert motion.certified
        assert motion.is_free(world)
        assert not panda.in_collision(motion.at(np.linspace(0, motion.duration, 3001)).q, world).any()
    assert made > 4


@pytest.mark.parametrize("options", LIMITS)
def test_two_motions_one_after_the_other_are_one_that_does_not_stop(panda, options):
    rng = np.random.default_rng(0)
    points = panda.home + np.cumsum(0.2 * rng.normal(size=(7, 7)), axis=0)
    way = points[4] - points[3]
    middle, velocity = points[3] + 0.5 * way, 0.4 * way / np.linalg.norm(way)
    first = panda.trajectory([*points[:4], middle], end_velocity=velocity, **options)
    second = panda.trajectory([middle, *points[4:]], start_velocity=velocity, **options)
    judge(first, np.zeros(7), velocity)
    judge(second, velocity, np.zeros(7))
    later = second.at(0.01)
    assert np.allclose(first.at(first.duration + 1e-4).q, second.at(1e-4).q, atol=1e-6)
    assert np.abs(later.qd).max() > 0.1


def test_it_is_slowed_replaced_written_and_sent_with_its_velocities(panda, tmp_path):
    end = panda.home + 0.5
    velocity = np.full(7, 0.2)
    motion = panda.plan(panda.home, end).trajectory(start_velocity=velocity, end_velocity=velocity, **FRANKA)
    judge(motion.slowed(0.5), velocity / 2, velocity / 2)
    t = 0.5 * motion.duration
    judge(motion.replace(panda.plan(motion.at(t).q, panda.home), at=t), velocity, np.zeros(7))
    samples = motion.sampled(0.001)
    assert np.array_equal(samples.qd[-1], velocity)
    assert np.allclose(samples.q[-1], end + (samples.t[-1] - motion.duration) * velocity, atol=1e-12)
    before, after = motion.at([-0.5, motion.duration + 0.5]).q
    assert np.allclose([before, after], [panda.home - 0.1, end + 0.1], atol=1e-12)
    motion.to_csv(tmp_path / "motion.csv")
    table = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    assert np.allclose(table[[0, -1], 8:15], 0.2)


@pytest.mark.parametrize("speed", [0.5, 1.9, 2.1])
def test_on_a_line_no_acceleration_is_lost_to_how_far_a_motion_may_leave_it(panda, speed):
    line = np.stack([panda.home, panda.home + np.eye(7)[0]])
    durations = [
        panda.trajectory(line, acceleration=5.0, jerk=50.0, start_velocity=speed * np.eye(7)[0], within=within).duration
        for within in (1e-5, 1e-2)
    ]
    assert durations[0] == pytest.approx(durations[1], rel=1e-9)


def test_an_arm_at_rest_does_not_take_a_motion_that_moves_at_an_end():
    robot = ulna.load("panda")
    motion = robot.plan(robot.home, robot.home + 0.2).trajectory(start_velocity=np.full(7, 0.1), **FRANKA)
    with pytest.raises(InputError, match="motion: it does not start and end at rest, as the arm does"):
        Recorder(robot.home).run(motion)


def test_a_start_that_is_the_goal_is_left_and_reached_again(panda):
    velocity = np.array([0.3, 0, 0, 0, 0, 0, 0])
    for options in LIMITS:
        motion = panda.plan(panda.home, panda.home).trajectory(start_velocity=velocity, **options)
        judge(motion, velocity, np.zeros(7))
        assert np.allclose(motion.q[[0, -1]], panda.home, atol=1e-12)
    with pytest.raises(InputError, match="start_velocity: it has to be along the first line"):
        panda.trajectory(panda.home[None], start_velocity=velocity, **FRANKA)


def test_velocities_of_zero_are_rest(panda):
    plan = panda.plan(panda.home, panda.home + 0.3)
    still = plan.trajectory(start_velocity=np.zeros(7), end_velocity=np.zeros(7), **FRANKA)
    assert np.array_equal(still.times, plan.trajectory(**FRANKA).times)
    assert panda.plan(panda.home, panda.home).trajectory(start_velocity=np.zeros(7), **FRANKA).duration == 0


@pytest.mark.parametrize("which", ["start_velocity", "end_velocity"])
def test_what_cannot_be_is_refused_by_name(panda, plan, which):
    points = panda.home + np.array([[0.0], [0.01], [0.4]]) * np.ones(7)
    for velocity, message in (
        (np.zeros(6), "7 finite numbers"),
        (0.1, "7 finite numbers"),
        (np.full(7, np.nan), "7 finite numbers"),
        ("fast", "not an array of numbers"),
        (np.full(7, 3.0), "3 of panda_joint1, whose limit is 2.175"),
    ):
        with pytest.raises(InputError, match=f"{which}.*{message}"):
            plan.trajectory(**{which: velocity}, **FRANKA)
    with pytest.raises(InputError, match=f"{which}: it has to be along"):
        panda.trajectory(points, **{which: np.array([0.1, 0, 0, 0, 0, 0, 0])}, **FRANKA)
    with pytest.raises(InputError, match=f"{which}: it has to be along"):
        panda.trajectory(points, **{which: -np.full(7, 0.1)}, **FRANKA)
    with pytest.raises(InputError, match=f"{which}: .*long enough"):  # 2 rad/s on 0.04 rad
        panda.trajectory(panda.home + np.array([[0.0], [0.04]]) * np.ones(7), **{which: np.full(7, 2.0)}, **FRANKA)


def test_a_way_that_is_not_free_is_refused(panda):
    """A table below the fingers: the hand cannot go straight on into it."""
    x, y, z = panda.forward_kinematics(panda.home)[:3, 3]
    world = ulna.World()
    world.add("table", ulna.Box((0.2, 0.2, 0.1)), ulna.pose((x, y, z - 0.2)))
    up, down = panda.home.copy(), np.zeros(7)
    up[0] += 0.5
    down[1], down[3] = 1.0, 0.0
    plan = panda.plan(panda.home, up, world)
    with pytest.raises(InputError, match="start_velocity: no motion that starts straight"):
        plan.trajectory(start_velocity=1.5 * down, **SLOW)
    assert plan.trajectory(start_velocity=-0.2 * down, **SLOW).certified


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 0.4])
@pytest.mark.parametrize("options", [SLOW, SUDDEN])
def test_slides_joints_without_limits_and_paths_of_billionths(scale, options):
    robot = ulna.load("""<robot name="r"><link name="a"/><link name="b"/><link name="c">
      <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
      <joint name="lift" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" velocity="0.5" effort="1"/></joint>
      <joint name="turn" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint></robot>""")
    start, goal = np.zeros(2), scale * np.array([1.0, 2.0])
    for velocities in (([0.1, -0.3], [0.0, 0.0]), ([0.0, 0.0], [-0.2, 0.4]), ([0.1, 0.2], [0.2, 0.4])):
        motion = robot.plan(start, goal).trajectory(start_velocity=velocities[0], end_velocity=velocities[1], **options)
        moment = motion.at(np.linspace(0, motion.duration, 5001))
        assert np.allclose(moment.q[[0, -1]], [start, goal], atol=1e-12)
        assert np.allclose(moment.qd[[0, -1]], velocities, atol=1e-9)
        for rates, most in zip(moment[1:], motion._limits, strict=True):
            assert most is None or (np.abs(rates) <= most * (1 + 1e-9)).all()


def braked(speed, acceleration, jerk, h=1e-5):
    """How far a joint moves until it rests, by small steps: its acceleration grows as fast as lets it end at 0 with the speed."""
    way = a = 0.0
    while speed > 0.0:
        growing = jerk == np.inf or a * a / (2 * jerk) < speed
        a = acceleration if jerk == np.inf else min(a + jerk * h, acceleration) if growing else max(a - jerk * h, jerk * h)
        way, speed = way + h * speed, speed - a * h
    return way


@pytest.mark.parametrize("jerk", [None, 20.0, 200.0])
@pytest.mark.parametrize(("which", "side"), [("start_velocity", 1), ("end_velocity", 1), ("end_velocity", -1)])
def test_a_velocity_that_cannot_stop_within_the_limits_of_position_is_refused_by_joint_and_amount(panda, jerk, which, side):
    """On both sides of the distance in which a joint stops, which is found by small steps."""
    speed, acceleration = 0.8, 4.0
    way = braked(speed, acceleration, np.inf if jerk is None else jerk)
    velocity, end = np.zeros(7), np.where(side > 0, panda.upper, panda.lower)[0]
    velocity[0] = side * speed
    for room, stops in ((1.02 * way, True), (0.98 * way, False)):
        near = panda.home.copy()
        near[0] = end - side * room
        path = [near, near - [side, 0, 0, 0, 0, 0, 0]] if which == "start_velocity" else [near - [side, 0, 0, 0, 0, 0, 0], near]
        plan = panda.plan(*path)
        options = {which: velocity, "acceleration": acceleration, "jerk": jerk}
        if stops and which == "end_velocity":
            assert plan.trajectory(**options).check()
        elif not stops:
            limit = "upper" if side > 0 else "lower"
            with pytest.raises(
                InputError, match=rf"{which}: .* of panda_joint1 at .*, 0\.0\d+ beyond its {limit} limit of .*slower"
            ):
                plan.trajectory(**options)


@pytest.mark.parametrize("options", LIMITS)
def test_a_start_in_motion_near_an_end_stays_within_the_limits_or_is_refused(panda, options):
    kept = 0
    for room in (0.001, 0.01, 0.05, 0.2, 0.5):
        start, velocity = panda.home.copy(), np.array([0.8, 0.1, 0, 0, 0, 0, 0])
        start[0] = panda.upper[0] - room
        plan = panda.plan(start, panda.home)
        try:
            motion = plan.trajectory(start_velocity=velocity, **options)
        except InputError:
            with pytest.raises(InputError, match=r"beyond its upper limit of 2.8973"):
                plan.trajectory(start_velocity=velocity, **options)
            continue
        kept += 1
        assert (motion.at(np.linspace(0, motion.duration, 20_001)).q <= panda.upper).all()
        assert motion.check()
    assert kept >= 1
