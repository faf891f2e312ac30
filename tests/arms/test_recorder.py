"""A dry run: the commands of a motion are sent as they are, and what an arm would not take is refused before it begins."""

import csv

import numpy as np
import pytest

import ulna
from ulna.arms import FR3, Arm, ArmModel, Recorder

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
    with pytest.raises(ulna.InputError, match=r"Research 3 would abort it, .* acceleration of .* its limit of 10,"):
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
    with pytest.raises(ulna.InputError, match=r"starts 0.011 rad from where fr3_joint3 is, and 0.01 rad"):
        arm.run(motion_to(start, TURN))
    assert Recorder(fr3.home, start_tolerance=0.02).run(motion_to(start, TURN)).duration > 0


def test_positions_beyond_the_arms_limits_are_refused():
    panda = ulna.load("panda")  # its first joint goes further
    start = panda.home.copy()
    start[0] = 2.6
    goal = start.copy()
    goal[0] = 2.8
    motion = panda.plan(start, goal, None).trajectory(velocity=0.2, acceleration=1.0, jerk=100.0)
    with pytest.raises(ulna.InputError, match=r"panda_joint1 goes to 2.7.* rad, and the Franka .* from -2.7437 to 2.7437"):
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
