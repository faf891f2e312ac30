"""Certified plans among boxes, run by two simulators of a Franka's controller; and that the stricter one judges."""

import os
import threading
import time

import numpy as np
import pytest

import ulna
from ulna.arms import Franka

PLANS = int(os.environ.get("FRANKA_PLANS", "30"))
JUDGE = "franka-sim"  # it aborts a motion that exceeds the limits
ATTEMPTS = 4
BEHIND = 0.15  # [rad], of a joint at 1 rad/s
NEAR = 0.002  # [m]: the arm is a little beside the start of its motion


def run(arm, fr3, goal, world, late):
    """The record of a certified plan from where the arm is; an end near a limit of position is passed more slowly."""
    for _ in range(ATTEMPTS):
        plan = fr3.plan(arm.q, goal, world)
        motion = plan.trajectory(limits="fr3", velocity=1.0, acceleration=8.0)
        assert motion.certified
        speed = next(each for each in (1.0, 0.6, 0.3, 0.2) if motion.slowed(each).check("fr3"))
        try:
            return arm.run(motion, speed=speed)
        except ulna.ArmError as error:
            late.append(error.words)
            arm.recover()
    raise AssertionError(late)


def test_certified_plans_are_run_to_their_goals(arm, fr3, problems, floor):
    """A busy machine sends late, which aborts a motion as on a real arm: then it is planned again from where the arm stopped."""
    errors, ends, late, moved = [], [], [], 0.0  # late: the controller's words
    for start, goal, world in problems():
        if len(errors) == PLANS:
            break
        if start is not None and not fr3.plan(start, goal, world, clearance=NEAR):
            continue
        if start is not None:  # there is nothing but the floor around a simulated arm
            run(arm, fr3, start, floor, late)
        if not fr3.plan(arm.q, goal, world, clearance=NEAR):
            continue
        record = run(arm, fr3, goal, world, late)
        assert np.allclose(record.commanded[-1], goal, rtol=0.0, atol=1e-9)
        errors.append(record.tracking_error)
        ends.append(np.abs(arm.q - goal).max())
        moved += record.duration
    print(  # noqa: T201 - what the run says
        f"{arm.simulator}: {len(errors)} plans, {moved:.1f} s of motion, tracking error {np.median(errors):.4f} rad in the "
        f"median and {max(errors):.4f} at most, end {np.median(ends):.4f} and {max(ends):.4f}, run again {len(late)}: {late}"
    )
    assert np.median(errors) < BEHIND  # one run may be far behind where the simulator itself was late
    assert max(ends) < 0.03


def test_a_motion_without_limits_of_jerk_is_aborted_by_the_judge(arm, fr3, floor):
    if arm.simulator != JUDGE:
        pytest.skip("it takes any command")
    plan = fr3.plan(arm.q, fr3.home, floor)
    motion = plan.trajectory(velocity=1.0, acceleration=9.0)
    with pytest.raises(ulna.InputError, match="jerk="):
        arm.run(motion)
    with pytest.raises(ulna.ArmError, match=r"stopped by itself.*discontinuity") as caught:
        arm._follow(motion.sampled(0.001).q, motion.joint_names)
    error = caught.value
    assert "joint_motion_generator" in error.words
    assert np.abs(error.record.commanded[-1] - fr3.home).max() > 0.0  # the end was not commanded
    with pytest.raises(ulna.ArmError, match=r"arm.recover"):
        arm.run(fr3.plan(arm.q, fr3.home, floor).trajectory(limits="fr3", velocity=1.0, acceleration=8.0))
    arm.recover()
    assert np.abs(arm.q - error.q).max() < 0.03
    arm.run(fr3.plan(arm.q, fr3.home, floor).trajectory(limits="fr3", velocity=1.0, acceleration=8.0))
    assert np.abs(arm.q - fr3.home).max() < 0.03


def test_a_motion_is_stopped_and_another_begins_where_it_stopped(arm, fr3, floor):
    goal = fr3.home + np.eye(7)[0] * (1.0 if arm.q[0] < 0.5 else -1.0)
    motion = fr3.plan(arm.q, goal, floor).trajectory(limits="fr3", velocity=0.5, acceleration=5.0)
    timer = threading.Timer(1.0, arm.stop)
    timer.start()
    record = arm.run(motion)
    timer.join()
    assert record.stopped
    assert record.duration < motion.duration
    time.sleep(1.0)  # to rest
    assert np.abs(arm.q - record.measured[-1]).max() < 0.1
    arm.run(fr3.plan(arm.q, fr3.home, floor).trajectory(limits="fr3", velocity=0.5, acceleration=5.0), speed=0.8)
    assert np.abs(arm.q - fr3.home).max() < 0.03


def test_a_servo_is_followed_to_a_pose(arm, fr3, floor):
    goal = fr3.forward_kinematics(arm.q)
    goal[:3, 3] += [0.05, 0.1, 0.05]
    servo = fr3.servo(floor, acceleration=2.5, velocity=0.5)
    record = arm.follow(servo, lambda t, _: {"pose": goal} if t < 4.0 else None)
    print(f"{arm.simulator}: {record}, longest tick {servo.worst * 1e3:.2f} ms")  # noqa: T201 - what the run says
    assert np.abs(fr3.forward_kinematics(record.commanded[-1]) - goal).max() < 1e-3
    assert np.abs(arm.q - record.commanded[-1]).max() < 0.03


def test_another_arms_description_is_refused(arm):
    arm.close()
    with pytest.raises(ulna.InputError, match="the limits of panda_joint1, panda_joint4"):
        Franka(robot=ulna.load("panda"))
