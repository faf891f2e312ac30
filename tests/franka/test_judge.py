"""Every command of certified plans, before franka-sim's checks of the controller's limits; and that these checks judge."""

import numpy as np
import pytest
from franka_sim.control_modes import ControlMode
from franka_sim.limits.checker import MotionLimitChecker

import ulna
from ulna.arms import Recorder

PLANS = 100


def violation(commands):
    """The first command that the controller would abort, shape (7,), and why; or None."""
    judge = MotionLimitChecker(enforce=True)
    judge.start_motion(ControlMode.POSITION, {"q_d": commands[0].tolist(), "q": commands[0].tolist()}, 1)
    for k, q in enumerate(commands.tolist(), start=1):
        command = {"message_id": k, "q_c": q, "motion_generation_finished": k == len(commands)}
        judge.note_published(k)
        found = judge.check(command, q)
        if found is not None:
            return k, found.describe()
        judge.record(command, clean=True)
    return None


def motions(fr3, problems, **limits):
    """Motions of certified plans, among boxes one after another."""
    q, made = fr3.home, 0
    for start, goal, world in problems():
        plan = fr3.plan(q if start is None else start, goal, world, clearance=0.0 if start is None else 0.002)
        if plan:
            assert plan.certified
            yield plan.trajectory(**limits)
            made, q = made + 1, goal
        if made == PLANS:
            return


def test_every_command_of_a_hundred_plans_is_accepted(fr3, problems):
    speeds = []
    for motion in motions(fr3, problems, limits="fr3", velocity=2.0, acceleration=9.0):
        record, speed = None, 0.0
        for speed in (1.0, 0.7, 0.5, 0.3, 0.2):  # an end near a limit of position is passed more slowly
            try:
                record = Recorder(motion.q[0]).run(motion, speed=speed)
                break
            except ulna.InputError:
                continue
        assert record is not None
        assert violation(record.commanded) is None
        speeds.append(speed)
    assert len(speeds) == PLANS
    assert np.mean(np.array(speeds) == 1.0) > 0.4


def test_motions_without_limits_of_jerk_are_refused_and_most_are_aborted(fr3, problems):
    """A jump between two samples is shared by both, so not every one exceeds the limit by differences."""
    reasons = []
    for k, motion in enumerate(motions(fr3, problems, velocity=2.0, acceleration=10.0)):
        if k == 20:
            break
        reasons.append(violation(motion.sampled(0.001).q))
        with pytest.raises(ulna.InputError, match="jerk="):
            Recorder(motion.q[0]).run(motion)
    aborted = [why for _, why in filter(None, reasons)]
    assert sum("discontinuity" in why for why in aborted) > 10  # the others come too fast towards a limit of position


def steered(fr3, world, seed, **limits):
    """The commands of a servo that is sent to other goals each third of a second: poses, twists, velocities, configurations."""
    rng, arm, goals = np.random.default_rng(seed), Recorder(fr3.home), []
    for k in range(30):
        far = rng.uniform(fr3.lower, fr3.upper)
        twist, velocity = rng.normal(size=6), rng.choice([-1.0, 1.0], 7) * 3.0
        goals.append([{"pose": fr3.forward_kinematics(far)}, {"twist": twist}, {"velocity": velocity}, {"q": far}][k % 4])
    record = arm.follow(fr3.servo(world, **limits), lambda t, _: goals[int(3 * t)] if t < len(goals) / 3 else None)
    return np.concatenate([fr3.home[None], record.commanded])


def test_every_command_of_a_servo_with_a_limit_of_jerk_is_accepted(fr3, world):
    for seed in range(4):
        commands = steered(fr3, world, seed, acceleration=9.9, velocity=2.6, jerk=4990.0)
        assert violation(commands) is None
        assert np.abs(np.diff(commands, axis=0)).sum() > 5.0
        assert np.abs(np.diff(commands, n=2, axis=0)).max() / 1e-6 > 9.0


def test_without_it_one_of_such_acceleration_is_refused_and_would_be_aborted(fr3):
    with pytest.raises(ulna.InputError, match="jerk="):
        steered(fr3, None, 0, acceleration=9.9, velocity=2.6)
    servo, commands = fr3.servo(acceleration=9.9, velocity=2.6), [fr3.home]
    servo.start(fr3.home)
    commands.extend(servo.step(velocity=np.full(7, (-1.0) ** (k // 60))).q for k in range(200))
    assert "discontinuity" in violation(np.array(commands))[1]
