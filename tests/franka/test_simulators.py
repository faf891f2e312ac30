"""Certified plans among boxes, run by two simulators of a Franka's controller; and that the stricter one judges."""

import os
import threading
import time

import numpy as np
import pytest

import ulna
from ulna.arms import Franka

PLANS = int(os.environ.get("FRANKA_PLANS", "40"))
JUDGE = "franka-sim"  # it aborts a motion that exceeds the limits
BEHIND = 0.1  # [rad], of a joint at 1.5 rad/s


def test_certified_plans_are_run_and_none_is_aborted(arm, fr3, world):
    rng, errors, ends, lost, moved = np.random.default_rng(36), [], [], 0, 0.0
    while len(errors) < PLANS:
        goal = rng.uniform(fr3.lower, fr3.upper) * 0.9 + fr3.home * 0.1
        if fr3.in_collision(goal, world):
            continue
        plan = fr3.plan(arm.q, goal, world, clearance=0.01)
        if not plan:
            continue
        assert plan.certified
        motion = plan.trajectory(limits="fr3", velocity=1.5)
        assert motion.certified
        record = arm.run(motion)
        assert not record.stopped
        errors.append(record.tracking_error)
        ends.append(np.abs(arm.q - motion.q[-1]).max())
        lost, moved = lost + record.lost, moved + motion.duration
    print(  # noqa: T201 - what the run says
        f"{arm.simulator}: {len(errors)} plans, {moved:.1f} s of motion, tracking error {np.median(errors):.4f} rad in the "
        f"median and {max(errors):.4f} at most, end {np.median(ends):.4f} and {max(ends):.4f}, {lost} periods without a command"
    )
    assert max(errors) < BEHIND
    assert max(ends) < 0.01


def test_a_motion_without_limits_of_jerk_is_aborted_by_the_judge(arm, fr3):
    if arm.simulator != JUDGE:
        pytest.skip("it takes any command")
    plan = fr3.plan(arm.q, fr3.home, None)
    motion = plan.trajectory(velocity=1.5, acceleration=10.0)
    with pytest.raises(ulna.InputError, match="jerk="):
        arm.run(motion)
    with pytest.raises(ulna.ArmError, match=r"stopped by itself.*discontinuity") as caught:
        arm._follow(motion.sampled(0.001).q, motion.joint_names)
    error = caught.value
    assert "joint_motion_generator" in error.words
    assert len(error.record.commanded) < len(motion.sampled(0.001).q)
    with pytest.raises(ulna.ArmError, match=r"arm.recover"):
        arm.run(fr3.plan(arm.q, fr3.home, None).trajectory(limits="fr3", velocity=1.5))
    arm.recover()
    assert np.abs(arm.q - error.q).max() < 0.01
    arm.run(fr3.plan(arm.q, fr3.home, None).trajectory(limits="fr3", velocity=1.5))
    assert np.abs(arm.q - fr3.home).max() < 0.01


def test_a_motion_is_stopped_and_another_begins_where_it_stopped(arm, fr3):
    goal = fr3.home + np.eye(7)[0] * (1.0 if arm.q[0] < 0.5 else -1.0)
    motion = fr3.plan(arm.q, goal, None).trajectory(limits="fr3", velocity=0.5)
    timer = threading.Timer(1.0, arm.stop)
    timer.start()
    record = arm.run(motion)
    timer.join()
    assert record.stopped
    assert record.duration < motion.duration
    time.sleep(1.0)  # to rest
    assert np.abs(arm.q - record.measured[-1]).max() < 0.1
    arm.run(fr3.plan(arm.q, fr3.home, None).trajectory(limits="fr3", velocity=0.5), speed=0.8)
    assert np.abs(arm.q - fr3.home).max() < 0.01


def test_another_arms_description_is_refused(arm):
    arm.close()
    with pytest.raises(ulna.InputError, match="panda lets panda_joint1, panda_joint4"):
        Franka(robot=ulna.load("panda"))


def test_a_lost_connection_is_named(fr3, tmp_path):
    from simulators import simulator

    with simulator(JUDGE, tmp_path) as process, Franka(robot=fr3) as arm:
        goal = arm.q + np.eye(7)[0] * 1.5
        motion = fr3.plan(arm.q, goal, None).trajectory(limits="fr3", velocity=0.5)
        timer = threading.Timer(1.0, process.kill)
        timer.start()
        with pytest.raises(ulna.ArmConnectionError, match="connection was lost while the arm moved: libfranka") as caught:
            arm.run(motion)
        timer.join()
    q, record = caught.value.q, caught.value.record
    assert np.array_equal(q, record.measured[-1])
    assert motion.q[0][0] < q[0] < motion.q[-1][0]
