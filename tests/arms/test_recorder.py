"""A dry run: the commands of a motion are sent as they are, and what an arm would not take is refused before it begins."""

import csv

import numpy as np
import pytest

import ulna
from matrix import matrix
from ulna.arms import FR3, Arm, ArmModel, Recorder
from ulna.planning.arm_limits import ARMS
from ulna.planning.motion_check import Samples, check_of

TURN = np.array([0.5, 0.2, 0.0, 0.3, 0.0, 0.2, -0.4])


@pytest.fixture
def arm(fr3) -> Arm:
    return Recorder(fr3.home)


def test_every_millisecond_of_the_motion_is_commanded(arm, fr3, motion_to):
    motion = motion_to(arm.q, TURN)
    record = arm.run(motion)
    assert np.array_equal(record.commanded, motion.sampled(0.001).q)
    assert np.array_equal(record.commanded[0], fr3.home)
    assert np.array_equal(arm.q, motion.q[-1])
    assert record.joint_names == tuple(fr3.joint_names)
    assert record.duration == pytest.approx(motion.duration, abs=0.001)
    assert not record.stopped
    assert record.lost == 0
    assert arm.records == [record]


def test_runs_follow_one_another_and_all_are_recorded(arm, motion_to):
    first = arm.run(motion_to(arm.q, TURN))
    second = arm.run(motion_to(arm.q, -TURN))
    assert np.array_equal(second.commanded[0], first.commanded[-1])
    assert arm.records == [first, second]


def test_a_slower_run_takes_the_same_path_in_more_time(arm, motion_to):
    motion = motion_to(arm.q, TURN)
    record = arm.run(motion, speed=0.25)
    assert record.duration == pytest.approx(4 * motion.duration, abs=0.001)
    assert np.allclose(record.commanded[::4], motion.at(np.arange(len(record.commanded[::4])) * 0.001).q, rtol=0.0, atol=1e-12)


def test_a_motion_beyond_the_limits_is_taken_at_a_lower_speed(arm, motion_to):
    motion = motion_to(arm.q, TURN, acceleration=30.0, velocity=2.5, jerk=4000.0)
    with pytest.raises(ulna.InputError, match=r"Research 3 would abort it: .* acceleration of .* its limit of 10,"):
        arm.run(motion)
    assert arm.run(motion, speed=0.5).commanded.shape[1] == 7


def test_a_start_within_the_tolerance_is_approached_slowly(fr3, motion_to):
    away = np.array([0.009, -0.009, 0.0, 0.002, 0.0, 0.0, -0.005])
    arm, motion = Recorder(fr3.home + away), motion_to(fr3.home, TURN)
    commands = arm.run(motion).commanded
    assert np.allclose(commands[0], fr3.home + away, rtol=0.0, atol=1e-7)
    assert np.array_equal(commands[199:], motion.sampled(0.001).q)
    jerks = np.diff(np.concatenate([np.repeat(commands[:1], 3, axis=0), commands]), n=3, axis=0) / 1e-9
    assert np.abs(jerks[:199]).max() < 100.0
    between = np.sort(np.stack([fr3.home, fr3.home + away]), axis=0)
    assert ((commands[:199] >= between[0] - 1e-12) & (commands[:199] <= between[1] + 1e-12)).all()


@pytest.mark.parametrize("speed", [0.0, -1.0, 1.0001, 2, np.inf, np.nan, True, "0.5", None])
def test_other_speeds_are_refused(arm, motion_to, speed):
    with pytest.raises(ulna.InputError, match=r"speed: .* at most 1"):
        arm.run(motion_to(arm.q, TURN), speed=speed)


def test_a_motion_without_limits_of_jerk_is_refused_however_slow(arm, motion_to):
    motion = motion_to(arm.q, TURN, jerk=None, acceleration=0.5)
    with pytest.raises(ulna.InputError, match=r"motion: its acceleration jumps.*jerk="):
        arm.run(motion, speed=0.1)
    assert arm.records == []


def test_another_start_is_refused(arm, fr3, motion_to):
    start = fr3.home.copy()
    start[2] += 0.011
    with pytest.raises(ulna.InputError, match=r"starts 0.011 rad from the measured position of fr3_joint3; 0.01 rad"):
        arm.run(motion_to(start, TURN))
    assert Recorder(fr3.home, start_tolerance=0.02).run(motion_to(start, TURN)).duration > 0


def test_positions_beyond_the_arms_limits_are_refused():
    panda = ulna.load("panda")  # its first joint goes further
    start = panda.home.copy()
    start[0] = 2.6
    goal = start.copy()
    goal[0] = 2.8
    motion = panda.plan(start, goal, None).trajectory(velocity=0.2, acceleration=1.0, jerk=100.0)
    with pytest.raises(
        ulna.InputError, match=r"panda_joint1 goes to 2.7.* rad; the limits of the Franka .* are -2.7437 and 2.7437"
    ):
        Recorder(start).run(motion)


def test_another_number_of_joints_is_refused(arm):
    with pytest.raises(ulna.InputError, match="Trajectory is expected"):
        arm.run(np.zeros((10, 7)))  # type: ignore[arg-type]
    other = Recorder(np.zeros(2), model=ArmModel("planar arm", np.full(2, -3.0), np.full(2, 3.0), "fr3"))
    panda = ulna.load("panda")
    motion = panda.plan(panda.home, panda.home + 0.1, None).trajectory(acceleration=1.0, jerk=100.0)
    with pytest.raises(ulna.InputError, match="moves 7 joints, and the planar arm has 2"):
        other.run(motion)


@pytest.mark.parametrize("q", [np.zeros(6), np.zeros(7), np.full(7, np.nan), "home"])
def test_a_recorder_is_somewhere_within_the_limits(q):
    with pytest.raises(ulna.InputError, match="q"):
        Recorder(q)


def test_a_recorder_beyond_a_limit_says_which_joint_and_how_far(fr3):
    q = fr3.home.copy()
    q[3] = FR3.lower[3] - 0.02
    with pytest.raises(ulna.InputError, match=r"q: entry 3 is -3\.0621, 0\.02 beyond the limits of the Franka Research 3"):
        Recorder(q)


def test_limits_of_an_arm_are_checked():
    with pytest.raises(ulna.InputError, match="lower, upper"):
        ArmModel("a", np.ones(3), np.zeros(3), "fr3")
    with pytest.raises(ulna.InputError, match="lower, upper"):
        ArmModel("a", np.zeros(3), np.ones(4), "fr3")
    assert FR3.n_dof == 7


def test_a_record_is_written_as_a_table(arm, fr3, motion_to, tmp_path):
    record = arm.run(motion_to(arm.q, TURN))
    record.to_csv(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open() as file:
        names, *rows = csv.reader(file)
    assert names == ["time", *fr3.joint_names, *(f"measured_{name}" for name in fr3.joint_names)]
    assert np.array_equal(np.array(rows, dtype=float)[:, 1:8], record.commanded)
    with pytest.raises(ulna.FileError):
        record.to_csv(tmp_path)


def test_a_plan_that_does_not_move_is_one_command(arm, fr3):
    record = arm.run(fr3.plan(fr3.home, fr3.home, None).trajectory(acceleration=1.0, jerk=1.0))
    assert record.commanded.shape == (1, 7)
    assert record.tracking_error == 0.0


@pytest.mark.parametrize("tolerance", [2.0, -0.01, np.nan, True, "near"])
def test_a_tolerance_over_which_the_approach_would_be_too_fast_is_refused(fr3, tolerance):
    with pytest.raises(ulna.InputError, match="start_tolerance"):
        Recorder(fr3.home, start_tolerance=tolerance)


@pytest.fixture
def servo(fr3):
    return fr3.servo(acceleration=2.5, velocity=1.0, tracking_error=0.001)


def test_a_servo_is_followed_within_the_limits_to_its_goal_and_then_to_rest(arm, fr3, servo):
    goal = fr3.forward_kinematics(fr3.home)
    goal[:3, 3] += [0.0, 0.15, -0.1]
    record = arm.follow(servo, lambda t, _: {"pose": goal} if t < 3.0 else None)
    assert np.allclose(fr3.forward_kinematics(arm.q), goal, atol=1e-3)
    assert record.commanded.shape == record.measured.shape
    assert record.duration > 2.9
    kept = np.concatenate([np.repeat(fr3.home[None], 3, axis=0), record.commanded, np.repeat(arm.q[None], 3, axis=0)])
    for order, most in ((1, 1.0), (2, 2.5), (3, 5000.0)):
        assert np.abs(np.diff(kept, n=order, axis=0)).max() / 1e-3**order <= most * (1 + 1e-6)
    assert arm.records == [record]


def accepted(q, robot):
    """What the judge of ``motion.check`` says of commands, a millisecond apart, of an FR3 that rests before and after them."""
    samples = Samples(1e-3 * np.arange(len(q)), q, np.zeros_like(q), np.zeros_like(q))
    return check_of(samples, 1e-3, ARMS["fr3"], robot.joint_names, np.zeros((2, 7)))


@pytest.fixture(scope="module")
def jerk_limited(fr3):
    return fr3.servo(acceleration=9.0, velocity=2.0, jerk=4500.0)


def test_a_servo_with_a_limit_of_jerk_is_followed_with_more_acceleration(arm, fr3, jerk_limited):
    """The judge of motions takes its commands, and it is there sooner than one that is held to 2.5 rad/s^2."""
    goal, times = fr3.forward_kinematics(fr3.home), []
    goal[:3, 3] += [0.0, 0.25, -0.2]
    for servo in (jerk_limited, fr3.servo(acceleration=2.5, velocity=2.0)):
        arm = Recorder(fr3.home)
        record = arm.follow(servo, lambda t, _: {"pose": goal} if t < 2.0 else None)
        off = np.abs(fr3.forward_kinematics(record.commanded) - goal).max(axis=(1, 2))
        times.append(np.argmax(off < 1e-3))
        assert off[-1] < 1e-3
        q = np.concatenate([fr3.home[None], record.commanded])
        assert accepted(q, fr3)
        kept = np.concatenate([np.repeat(q[:1], 3, axis=0), q, np.repeat(q[-1:], 3, axis=0)])
        greatest = [np.abs(np.diff(kept, n=order, axis=0)).max() / 1e-3**order for order in (1, 2, 3)]
        assert greatest[0] <= 2.0
        assert greatest[1] <= servo.limits.acceleration[0] * (1 + 2e-6)
        assert greatest[2] <= 5000.0
    assert times[0] < 0.75 * times[1]


def test_without_the_limit_of_jerk_the_judge_refuses_as_much_acceleration(fr3):
    """So the test above can fail."""
    servo, q = fr3.servo(acceleration=9.0, velocity=2.0), [fr3.home]
    servo.start(fr3.home)
    q.extend(servo.step(velocity=[1.0, 0, 0, 0, 0, 0, 0]).q for _ in range(50))
    assert not accepted(np.array(q), fr3)


@pytest.mark.slow
@pytest.mark.parametrize("limits", [{"acceleration": 2.5}, {"acceleration": 9.0, "jerk": 4900.0}])
@pytest.mark.parametrize("sign", matrix([1.0, -1.0], [1.0]))
def test_a_servo_that_goes_to_the_end_of_every_joint_keeps_the_velocities_that_are_allowed_there(fr3, sign, limits):
    rows = [(0.301, 12.0), (0.201, 5.17), (0.201, 7.0), (0.301, 8.0), (0.351, 34.0), (0.351, 11.0), (0.351, 34.0)]
    upper = [2.7501, 1.7918, 2.9065, -0.1458, 2.8101, 4.5205, 3.0196]  # libfranka, rate_limiting.h
    lower = [-2.7501, -1.7918, -2.9065, -3.0481, -2.8101, 0.54092, -3.0196]
    for j in range(7):
        arm, velocity = Recorder(fr3.home), sign * np.eye(7)[j] * 2.0
        servo = fr3.servo(velocity=2.6, **limits)
        record = arm.follow(
            servo, lambda t, _q, velocity=velocity: {"velocity": velocity if t < 4 else -velocity} if t < 5 else None
        )
        q = np.concatenate([fr3.home[None], record.commanded])
        rates, (offset, rate) = np.diff(q[:, j]) / 1e-3, rows[j]
        left = upper[j] - q[1:, j] if sign > 0 else q[1:, j] - lower[j]
        allowed = np.sqrt(rate * np.maximum(left, 0.0)) - offset
        moving = sign * rates > 1e-9
        assert (sign * rates[moving] <= np.maximum(allowed[moving], 0.0) + 1e-9).all()
        farthest = np.max(sign * q[:, j])
        assert farthest - sign * q[0, j] > 0.2
        assert farthest - sign * q[-1, j] > 0.1  # it leaves the end again


@pytest.mark.parametrize(("joint", "side"), [(4, 1), (4, -1), (0, 1), (3, -1), (5, 1)])
def test_a_joint_that_turns_round_in_its_stop_keeps_the_velocity_allowed_in_each_direction(fr3, joint, side):
    """Near its end it is sent away, and then back: with little jerk the stop begins the other way.

    The judge is written out from libfranka's rate_limiting.h.
    """
    rows = [(0.301, 12.0), (0.201, 5.17), (0.201, 7.0), (0.301, 8.0), (0.351, 34.0), (0.351, 11.0), (0.351, 34.0)]
    ends = {1: [2.7501, 1.7918, 2.9065, -0.1458, 2.8101, 4.5205], -1: [-2.7501, -1.7918, -2.9065, -3.0481, -2.8101, 0.54092]}
    (offset, rate), end = rows[joint], ends[side][joint]
    servo, start = fr3.servo(acceleration=10.0, jerk=500.0, velocity=2.5), fr3.home.copy()
    start[joint] = (FR3.upper if side > 0 else FR3.lower)[joint] - side * 0.0005
    for back in (16, 22, 40):
        for speed in (0.03, 0.1):
            away = -side * speed * np.eye(7)[joint]
            record = Recorder(start).follow(
                servo, lambda t, _q, back=back, away=away: {"velocity": away if t < back * 1e-3 else -away} if t < 0.3 else None
            )
            q = side * np.concatenate([start[None], record.commanded])[:, joint]
            allowed = np.maximum(np.sqrt(np.maximum(rate * (side * end - q), 0.0)) - offset, 0.0)
            assert (np.diff(q) / 1e-3 <= np.maximum(allowed[1:], allowed[:-1]) + 1e-9).all()
            assert np.ptp(q) > 1e-4


def test_a_servo_that_the_arm_would_not_take_is_refused(arm, fr3):
    for options, match in (
        ({"acceleration": 2.5, "velocity": 2.0, "rate": 500}, "500 Hz"),
        ({"acceleration": 2.6, "velocity": 2.0}, r"acceleration limit of fr3_joint1 is 2.6; at most 2.5 is .* jerk limit"),
        ({"acceleration": 9.0, "velocity": 2.0, "jerk": 5100.0}, r"jerk limit of fr3_joint1 is 5100; at most 5000 is allowed"),
        ({"acceleration": 11.0, "velocity": 2.0, "jerk": 4000.0}, r"acceleration limit of fr3_joint1 is 11; at most 10 is"),
        ({"acceleration": 2.5}, r"velocity limit of fr3_joint1 is 2.62; at most 2.619 is allowed"),
    ):
        with pytest.raises(ulna.InputError, match=match):
            arm.follow(fr3.servo(**options), lambda *_: None)
    with pytest.raises(ulna.InputError, match="servo: Robot"):
        arm.follow(fr3, lambda *_: None)
    world = ulna.World()
    world.add("here", ulna.Sphere(0.1), fr3.forward_kinematics(fr3.home))
    with pytest.raises(ulna.InputError, match="not certainly free"):
        arm.follow(fr3.servo(world, acceleration=2.5, velocity=2.0), lambda *_: {})
    assert arm.records == []
