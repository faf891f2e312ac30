"""Motions keep the limits of torque at all times, by another library's torques, and use what the motors have."""

import copy
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

import ulna
from ulna.errors import InputError

LIMITS = np.array([40.0, 50.0, 40.0, 40.0, 6.0, 6.0, 6.0])  # less than a Panda has, so that they count
PAYLOAD = 2.0


@pytest.fixture(scope="module")
def held(panda):
    return panda.with_attached("part", ulna.Box((0.05, 0.05, 0.05)), np.eye(4), mass=PAYLOAD)


def peer_of(robot):
    model = pin.buildModelFromXML(ulna.load("panda").to_urdf())
    frame = model.frames[model.getFrameId("panda_ee", pin.FrameType.BODY)]
    if robot.attached:
        model.appendBodyToJoint(frame.parentJoint, pin.Inertia.FromBox(PAYLOAD, 0.05, 0.05, 0.05), frame.placement)
    return model, model.createData()


def largest_share(robot, motion):
    """The greatest torque as a share of its limit, 10,000 times a second."""
    model, data = peer_of(robot)
    moments = motion.at(np.arange(0.0, motion.duration, 1e-4))
    return max(np.abs(pin.rnea(model, data, *row) / LIMITS).max() for row in zip(*moments[:3], strict=True))


def paths(robot, n):
    """Corners of paths along which the motors hold the robot still."""
    random, found = np.random.default_rng(7), []
    while len(found) < n:
        start, way = robot.random(seed=int(random.integers(1e6))), random.normal(size=(3, 7))
        path = np.clip(np.vstack([start, start + np.cumsum(0.7 * way, axis=0)]), robot.lower, robot.upper)
        dense = np.concatenate([np.linspace(*ends, 50) for ends in pairwise(path)])
        if (np.abs(robot.gravity_torque(dense)) < 0.9 * LIMITS).all():
            found.append(path)
    return found


@pytest.mark.parametrize("options", [{}, {"jerk": 400.0}], ids=["", "jerk"])
@pytest.mark.parametrize("with_payload", [False, True], ids=["empty", "payload"])
def test_torques_are_within_their_limits_at_all_times(panda, held, options, with_payload):
    robot, used, counted = held if with_payload else panda, [], 0
    for path in paths(robot, 8):
        free, motion = (robot.trajectory(path, acceleration=15.0, within=0.05, torque=each, **options) for each in (None, LIMITS))
        share = largest_share(robot, motion)
        assert share <= 1.0
        assert motion.check(torque=LIMITS)
        counted += largest_share(robot, free) > 1.0
        if motion.duration > 1.01 * free.duration:
            used.append(share)
    assert counted >= 2
    assert min(used) > 0.9


def test_the_fastest_motion_of_one_joint_has_its_motor_at_the_limit_all_the_time():
    """A pendulum that hangs: from rest to rest the torque is at one limit and then at the other, as bang-bang control says."""
    arm = ulna.Robot.from_dh([(0, 0, 0, 0)]).with_gravity((9.81, 0, 0))
    arm = arm.with_inertias({"link1": ulna.Inertia(1.0, (0.5, 0, 0), np.diag([0, 0, 0.02]))})
    motion = arm.trajectory([[-1.0], [1.0]], acceleration=1e3, velocity=100.0, torque=6.0)
    torque = motion.torques(np.linspace(0.001, motion.duration - 0.001, 500))[:, 0]
    assert (np.abs(torque) > 0.98 * 6.0).mean() > 0.97
    assert np.abs(torque).max() <= 6.0


def test_a_payload_makes_a_motion_slower(panda, held):
    path = [panda.home, panda.home + np.array([1.0, 0.4, 0, 0.3, 0, 0, 0])]
    with_part, without = (robot.trajectory(path, acceleration=60.0, torque=LIMITS) for robot in (held, panda))
    assert with_part.duration > 1.02 * without.duration


def test_an_arm_that_its_motors_cannot_hold_on_the_way_is_refused_with_the_joint(panda):
    heavy = panda.with_attached("part", ulna.Box((0.05, 0.05, 0.05)), np.eye(4), mass=12.0)
    folded, stretched = panda.home, panda.home + np.array([0, 1.2, 0, 1.8, 0, 0, 0])
    with pytest.raises(InputError, match=r"torque: panda_joint\d needs \d+\.?\d* to hold the robot still at \d+ % of the path"):
        heavy.trajectory([folded, stretched], acceleration=5.0, torque=True)


def test_a_plan_and_its_changes_keep_the_torques(panda):
    goal = panda.home + np.array([1.0, 0.5, 0.3, 0.5, -0.5, 0.6, 0.4])
    plan = panda.plan(panda.home, goal)
    motion = plan.trajectory(acceleration=15.0, jerk=400.0, torque=LIMITS)
    for each in (motion, motion.slowed(0.7), copy.deepcopy(motion), motion.then(motion_back(panda, goal))):
        assert largest_share(panda, each) <= 1.0
    at = 0.4 * motion.duration
    other = panda.plan(motion.at(at).q, panda.home + np.array([-0.5, 0.5, 0.3, 0.5, -0.5, 0.6, 0.4]))
    assert largest_share(panda, motion.replace(other, at=at)) <= 1.0
    quicker = plan.quicker(5, acceleration=15.0, torque=LIMITS)
    assert largest_share(panda, quicker.trajectory(acceleration=15.0, torque=LIMITS)) <= 1.0


def motion_back(panda, goal):
    return panda.plan(goal, panda.home).trajectory(acceleration=15.0, jerk=400.0, torque=LIMITS)


def test_a_plot_has_the_torques_and_their_limits(panda):
    motion = panda.trajectory([panda.home, panda.home + 0.3], acceleration=15.0, torque=LIMITS)
    axes = motion.plot().axes
    assert [each.get_ylabel() for each in axes[-2:]] == ["acceleration [1/s²]", "torque [Nm or N]"]
    t, torque = axes[-1].lines[1].get_data()
    assert np.allclose(torque, motion.torques(t)[:, 1])
    assert {line.get_ydata()[0] for line in axes[-1].lines[7:]} <= {*LIMITS, *-LIMITS}
    assert len(axes[-1].lines) > 7


def test_a_check_names_the_joint_and_the_moment(panda):
    path = [panda.home, panda.home + np.array([1.0, 0.4, 0, 0.3, 0, 0, 0])]
    motion = panda.trajectory(path, acceleration=15.0)
    check = motion.check(torque=0.5 * LIMITS)
    torque = np.abs(motion.torques(np.arange(0, motion.duration, 1e-4)) / (0.5 * LIMITS))
    assert not check
    assert check.quantity == "torque"
    assert check.joint == panda.joint_names[int(torque.max(axis=0).argmax())]
    assert f"beyond a limit: the torque of {check.joint} peaks at" in str(check)
    assert check.value / check.limit == pytest.approx(torque.max(), rel=1e-3)
    assert motion.check(torque=False)
    assert "torque" in str(motion.check(torque=True))


def test_velocities_at_the_ends_that_the_motors_cannot_keep_are_refused(panda):
    path, fast = [panda.home, panda.home + 0.5], 2.0 * np.ones(7)
    limits = 1.1 * np.abs(panda.gravity_torque(panda.home)) + 0.5
    beyond = np.abs(panda.inverse_dynamics(panda.home, fast, np.zeros(7))) > limits
    assert beyond.any()
    with pytest.raises(InputError, match=r"start_velocity: panda_joint\d would need a torque of .* to hold this velocity"):
        panda.trajectory(path, acceleration=15.0, torque=limits, start_velocity=fast)


@pytest.mark.parametrize("torque", [0.0, -1.0, np.ones(3), np.nan, "strong"])
def test_limits_that_are_none_are_refused(panda, torque):
    with pytest.raises(InputError, match="torque"):
        panda.trajectory([panda.home, panda.home + 0.1], acceleration=5.0, torque=torque)


def test_truths_of_numpy_are_truths(panda):
    path = [panda.home, panda.home + 0.1]
    limits = [panda.trajectory(path, acceleration=5.0, torque=each).check().torques[0].limit for each in (True, np.True_)]
    assert limits[0] == limits[1] >= 12.0
    assert not panda.trajectory(path, acceleration=5.0, torque=np.False_).check().torques
    assert panda.payload(panda.home, torque=np.True_) == panda.payload(panda.home)


def test_a_torque_within_the_margin_says_so(panda):
    motion = panda.trajectory([panda.home, panda.home + 0.5], acceleration=15.0)
    peaks = np.abs(motion.torques(np.linspace(0, motion.duration, 20_000))).max(axis=0)
    check = motion.check(torque=1.002 * peaks)
    assert not check
    assert "99.8" in str(check)
    assert "; 0.5 % of it is a margin for torques between samples" in str(check)


def test_a_robot_without_inertias_or_efforts_is_refused(panda):
    path = [panda.home, panda.home + 0.1]
    with pytest.raises(ulna.InertiaError, match="panda_link4"):
        panda.with_inertias({"panda_link4": None}).trajectory(path, acceleration=5.0, torque=True)
    arm = ulna.Robot.from_dh([(0, 0, 0, 0)]).with_inertias({"link1": ulna.Inertia(1.0, (0.5, 0, 0), np.eye(3))})
    with pytest.raises(InputError, match="the description has no effort limit above 0 for joint1"):
        arm.trajectory([[0.0], [1.0]], acceleration=5.0, velocity=5.0, torque=True)
