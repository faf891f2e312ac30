"""The driver of a Franka with a client that is not there (conftest): what is sent, refused, stopped and reported."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import ulna
from ulna.arms import Franka

TURN = np.array([0.3, 0.1, 0.0, 0.2, 0.0, 0.2, -0.4])


def test_a_motion_is_sent_each_millisecond_and_ends_at_rest(controller, fr3, motion_to):
    with Franka(robot=fr3) as arm:
        motion = motion_to(arm.q, TURN)
        record = arm.run(motion)
    sent = np.array([command.q for command in controller.commands])
    body = motion.sampled(0.001).q
    assert np.array_equal(sent[: len(body)], body)
    assert np.array_equal(sent[len(body) :], np.repeat(motion.q[-1:], 100, axis=0))
    assert [command.motion_finished for command in controller.commands] == [False] * (len(sent) - 1) + [True]
    assert np.array_equal(record.commanded, sent)
    assert record.tracking_error == 0.0
    assert not record.stopped


def test_connecting_commands_nothing(controller, fr3):
    arm = Franka(robot=fr3)
    assert np.array_equal(arm.q, fr3.home)
    assert controller.calls == [("127.0.0.1", "ignore")]
    assert controller.commands == []
    Franka("10.0.0.2", realtime=True)
    assert controller.calls[-1] == ("10.0.0.2", "enforce")


def test_commands_begin_where_the_controller_commands_now(controller, motion_to):
    controller.q_d = controller.q + 0.004
    motion = motion_to(controller.q, TURN)
    Franka().run(motion)
    sent = np.array([command.q for command in controller.commands])
    assert np.abs(sent[0] - motion.q[0] - 0.004).max() < 1e-6
    assert np.array_equal(sent[199], motion.q[0])


def test_nothing_is_sent_where_commanded_and_measured_positions_differ(controller, motion_to):
    controller.q_d = controller.q + 0.03
    with pytest.raises(ulna.ArmError, match="commanded position is not the measured one"):
        Franka().run(motion_to(controller.q, TURN))
    assert controller.commands == []
    assert controller.calls[-1] == "stop"


def test_an_arm_that_something_holds_is_stopped(controller, motion_to):
    controller.held = True
    with pytest.raises(ulna.ArmError, match=r"fr3_joint7 is 0\.1 rad from all commands .* 0\.2 s.*: it was stopped") as caught:
        Franka().run(motion_to(controller.q, 3 * TURN))
    commanded = caught.value.record.commanded
    assert np.abs(commanded[-200] - controller.q).max() == pytest.approx(0.1, abs=0.003)
    assert controller.calls[-1] == "stop"


def test_a_slow_arm_that_something_holds_is_stopped_before_its_motion_ends(controller, fr3, motion_to):
    controller.floor = np.full(7, np.inf)
    controller.floor[0] = 0.05
    with pytest.raises(ulna.ArmError, match=r"fr3_joint1 is 0\.1 rad from all commands"):
        Franka().run(motion_to(controller.q, TURN, velocity=0.1))


def test_an_arm_that_follows_far_behind_a_fast_motion_is_not_stopped(controller, fr3, motion_to):
    controller.behind = 180
    record = Franka().run(motion_to(controller.q, 4 * TURN, velocity=2.4, acceleration=9.0, jerk=4500.0))
    assert record.tracking_error > 0.25


def test_a_record_says_where_the_arm_ended_beside_its_goal(controller, fr3, motion_to):
    motion = motion_to(controller.q, TURN)
    assert Franka().run(motion)
    controller.q = controller.q_d = fr3.home
    controller.late = []
    controller.floor = np.full(7, np.inf)
    controller.floor[1] = motion.q[-1, 1] - 0.06
    record = Franka().run(motion)
    assert not record
    assert not record.stopped
    assert np.array_equal(record.goal, motion.q[-1])
    assert np.array_equal(record.q_end, controller.q)
    assert record.ended.startswith(f"0.06 rad from the goal: fr3_joint2 is at {controller.q[1]:.4g}, and the goal is ")
    assert record.ended in str(record)
    controller.q = controller.q_d = fr3.home
    controller.floor, controller.at_tick = None, (80, (arm := Franka()).stop)
    stopped = arm.run(motion)
    assert not stopped
    assert np.array_equal(stopped.goal, motion.q[-1])


def test_periods_that_are_lost_are_skipped(controller, motion_to):
    controller.skip_at = 50
    motion = motion_to(controller.q, TURN)
    record = Franka().run(motion)
    assert record.lost == 3
    assert np.array_equal(record.commanded[50], motion.sampled(0.001).q[53])
    assert record.times[50] == pytest.approx(0.053)


def test_a_motion_is_stopped_from_another_place(controller, motion_to):
    arm = Franka()
    controller.at_tick = 80, arm.stop
    record = arm.run(motion_to(arm.q, TURN))
    assert record.stopped
    assert len(record.commanded) == 80
    assert controller.calls[-1] == "stop"
    controller.at_tick = None
    assert not arm.run(motion_to(arm.q, TURN)).stopped


def test_a_connection_that_is_closed_while_the_arm_moves_ends_when_it_has_stopped(controller, motion_to):
    arm = Franka()
    motion = motion_to(arm.q, TURN)
    controller.at_tick = 80, arm.close
    assert arm.run(motion).stopped
    with pytest.raises(ulna.ArmConnectionError, match="was closed"):
        arm.run(motion)


def test_the_measured_positions_can_be_read_while_it_moves(controller, motion_to):
    arm, seen = Franka(), []
    controller.at_tick = 300, lambda: seen.append(arm.q)
    record = arm.run(motion_to(arm.q, TURN))
    assert np.array_equal(seen[0], record.measured[299])
    controller.at_tick = 10, lambda: arm.run(motion_to(arm.q, TURN))
    with pytest.raises(ulna.ArmError, match="another motion is running"):
        arm.run(motion_to(arm.q, -TURN))


def test_a_reflex_is_named_with_the_controllers_words_and_where_the_arm_is(controller, motion_to):
    arm = Franka()
    controller.fail_at, controller.failure = 120, client("ControlException")('aborted by reflex! ["cartesian_reflex"]')
    with pytest.raises(ulna.ArmError, match=r"stopped by itself: aborted by reflex! .* measured at q = \(") as caught:
        arm.run(motion_to(arm.q, TURN))
    error = caught.value
    assert not isinstance(error, ulna.ArmConnectionError)
    assert error.words == 'aborted by reflex! ["cartesian_reflex"]'
    assert np.array_equal(error.q, controller.q)
    assert len(error.record.commanded) == 120
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301 - its own
    assert (str(copy), copy.q) == (str(error), error.q)
    with pytest.raises(ulna.ArmError, match=r"arm.recover\(\).*a_reflex"):
        arm.run(motion_to(arm.q, TURN))
    arm.recover()
    controller.fail_at = None
    assert arm.run(motion_to(arm.q, TURN)).duration > 0


def test_a_lost_connection_is_named_with_where_the_arm_was(controller, motion_to):
    arm = Franka()
    controller.fail_at, controller.failure = 60, client("NetworkException")("libfranka: UDP receive: Timeout")
    with pytest.raises(ulna.ArmConnectionError, match="connection was lost while the arm moved: libfranka: UDP") as caught:
        arm.run(motion_to(arm.q, TURN))
    assert np.array_equal(caught.value.q, caught.value.record.measured[-1])


def test_ctrl_c_stops_the_arm(controller, motion_to):
    def interrupt():
        raise KeyboardInterrupt

    arm, controller.at_tick = Franka(), (40, interrupt)
    with pytest.raises(KeyboardInterrupt):
        arm.run(motion_to(arm.q, TURN))
    assert controller.calls[-1] == "stop"


def test_an_error_of_the_clients_network_library_is_named(controller, monkeypatch):
    arm = Franka()

    def fails():
        raise RuntimeError("Net Exception")

    monkeypatch.setattr(controller, "state", fails)
    with pytest.raises(ulna.ArmConnectionError, match="cannot be read: Net Exception"):
        _ = arm.q


def test_no_controller_and_a_closed_connection_are_named(controller):
    with pytest.raises(ulna.ArmConnectionError, match=r"no connection to a Franka at 10.0.0.9: libfranka: Connection timeout"):
        Franka("10.0.0.9")
    with Franka() as arm:
        pass
    with pytest.raises(ulna.ArmConnectionError, match="was closed"):
        _ = arm.q


def test_what_is_refused_commands_nothing(controller, fr3, motion_to):
    arm = Franka(robot=fr3)
    started = len(controller.calls)
    for motion, speed in (
        (motion_to(arm.q, TURN, jerk=None), 1.0),
        (motion_to(arm.q, TURN), 1.5),
        (motion_to(arm.q + 0.02, TURN), 1.0),
    ):
        with pytest.raises(ulna.InputError):
            arm.run(motion, speed=speed)
    panda = ulna.load("panda")
    motion = panda.plan(arm.q, arm.q + TURN, None).trajectory(velocity=1.0, acceleration=5.0, jerk=2000.0)
    with pytest.raises(ulna.InputError, match=r"panda_joint1.*fr3_joint1"):
        arm.run(motion)
    assert controller.calls[started:] == []


def test_another_arms_description_is_refused(controller, fr3):
    with pytest.raises(ulna.InputError, match="the limits of panda_joint1, panda_joint4"):
        Franka(robot=ulna.load("panda"))
    with pytest.raises(ulna.InputError, match=r"7 revolute joints"):
        Franka(robot=ulna.load("ur5"))
    with pytest.raises(ulna.InputError, match="7 revolute joints"):
        Franka(robot=ulna.load("fr3", tip="fr3_link6"))
    joints = list(fr3.description.joints)
    k = next(k for k, joint in enumerate(joints) if joint.name == "fr3_joint5")
    origin = joints[k].origin.copy()
    origin[1, 3] += 0.01
    joints[k] = replace(joints[k], origin=origin)
    with pytest.raises(ulna.InputError, match=r"last joint axis of .* is 10.0 mm off the measured one"):
        Franka(robot=ulna.Robot(replace(fr3.description, joints=tuple(joints))))


def test_without_the_client_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pylibfranka", None)
    with pytest.raises(ulna.MissingExtraError, match=r"\[franka\]"):
        Franka()


def client(name):
    """An exception of the client that is not there."""
    import pylibfranka

    return getattr(pylibfranka, name)


def test_a_servo_is_followed_each_millisecond_and_what_was_late_is_caught_up(controller, fr3):
    controller.skip_at = 50
    goal = fr3.home + TURN
    with Franka(robot=fr3) as arm:
        servo = fr3.servo(acceleration=2.5, velocity=1.0)
        record = arm.follow(servo, lambda t, _: {"q": goal} if t < 2.0 else None)
        assert np.allclose(arm.q, goal, atol=1e-3)
    sent = np.array([command.q for command in controller.commands])
    assert np.array_equal(sent, record.commanded)
    assert np.array_equal(sent[0], fr3.home)
    assert [command.motion_finished for command in controller.commands] == [False] * (len(sent) - 1) + [True]
    assert record.lost == 3
    assert np.abs(sent[50] - sent[49]).max() > 3.5 * np.abs(sent[49] - sent[48]).max()  # four ticks at once
    others = np.delete(np.diff(sent, axis=0), slice(45, 55), axis=0) / 1e-3
    assert np.abs(others).max() <= 1.0
    assert np.array_equal(sent[-100], sent[-1])


def test_a_goal_that_fails_stops_the_arm_and_a_wrong_servo_moves_nothing(controller, fr3):
    arm = Franka(robot=fr3)

    def goal(t, _):
        if t > 0.1:
            raise KeyError("lost")
        return {"twist": [0.1, 0, 0, 0, 0, 0]}

    with pytest.raises(KeyError, match="lost"):
        arm.follow(fr3.servo(acceleration=2.5, velocity=1.0), goal)
    assert controller.calls[-1] == "stop"
    n = len(controller.commands)
    assert n > 50
    with pytest.raises(ulna.InputError, match="servo: its joints are"):
        arm.follow(ulna.load("panda").servo(acceleration=2.5, velocity=1.0), goal)
    controller.mode = controller.Reflex
    with pytest.raises(ulna.ArmError, match="cannot move"):
        arm.follow(fr3.servo(acceleration=2.5, velocity=1.0), goal)
    assert len(controller.commands) == n
