"""The ROS message of a trajectory, by classes with the fields of ROS 1 and 2, and the strictness of the latter."""

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import ulna
from ulna.errors import InputError, MissingROSError, UnknownNameError

FIELDS = {"ros1": ("secs", "nsecs"), "ros2": ("sec", "nanosec")}


def point_class(names):
    """A point whose duration has these fields alone."""

    @dataclass
    class JointTrajectoryPoint:
        positions: list = field(default_factory=list)
        velocities: list = field(default_factory=list)
        accelerations: list = field(default_factory=list)
        time_from_start: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(**dict.fromkeys(names, 0)))

        def __post_init__(self):
            for values in (self.positions, self.velocities, self.accelerations):
                assert all(type(value) is float for value in values)  # rclpy refuses NumPy's

    return JointTrajectoryPoint


@dataclass
class JointTrajectory:
    joint_names: list
    points: list


@pytest.fixture(params=FIELDS)
def names(request, monkeypatch):
    messages = ModuleType("trajectory_msgs.msg")
    messages.JointTrajectory, messages.JointTrajectoryPoint = JointTrajectory, point_class(FIELDS[request.param])
    monkeypatch.setitem(sys.modules, "trajectory_msgs", ModuleType("trajectory_msgs"))
    monkeypatch.setitem(sys.modules, "trajectory_msgs.msg", messages)
    return FIELDS[request.param]


@pytest.fixture(scope="module")
def motion(panda):
    return panda.plan(panda.home, panda.home + 0.3).trajectory(acceleration=3.0)


def times_of(message, names):
    parts = [[getattr(point.time_from_start, name) for name in names] for point in message.points]
    assert all(0 <= rest < 10**9 for _, rest in parts)
    return np.array([whole + 1e-9 * rest for whole, rest in parts])


def test_the_points_are_the_motion_at_even_times_from_rest_to_rest(motion, names):
    message = motion.to_ros(period=0.05)
    t = times_of(message, names)
    assert t[0] == 0
    assert t[-1] == pytest.approx(motion.duration, abs=1e-9)
    assert np.allclose(np.diff(t), t[1], atol=2e-9)
    assert t[1] <= 0.05
    assert message.joint_names == list(motion.joint_names)
    for k in (0, len(t) // 2, len(t) - 1):
        moment, point = motion.at(t[k]), message.points[k]
        assert np.allclose(point.positions, moment.q, atol=1e-7)
        assert np.allclose(point.velocities, moment.qd, atol=1e-7)
        assert np.allclose(point.accelerations, moment.qdd, atol=1e-7)
    assert message.points[0].velocities == message.points[-1].velocities == [0.0] * 7


def test_the_joints_are_those_asked_for_in_their_order(motion, names):
    chosen = [motion.joint_names[5], motion.joint_names[1]]
    message = motion.to_ros(chosen)
    assert message.joint_names == chosen
    assert np.array_equal(message.points[-1].positions, motion.q[-1][[5, 1]])
    with pytest.raises(UnknownNameError, match="no joint is called 'elbow'"):
        motion.to_ros(["elbow"])
    with pytest.raises(InputError, match=f"joint_names: '{chosen[0]}' is named twice"):
        motion.to_ros([*chosen, chosen[0]])
    with pytest.raises(InputError, match="joint_names: no joint is named"):
        motion.to_ros([])
    with pytest.raises(InputError, match="period"):
        motion.to_ros(period=0)


@pytest.mark.parametrize("options", [{"blend": 0.0}, {"blend": 0.0, "jerk": 30.0}])
@pytest.mark.parametrize("period", [0.013, 60.0])
def test_each_stop_on_the_way_is_a_point_at_rest(panda, names, options, period):
    world, left, right = ulna.World(), panda.home.copy(), panda.home.copy()
    world.add("post", ulna.Box((0.1, 0.1, 1.6)), ulna.pose((0.35, 0, 0.6)))
    world.add("shelf", ulna.Box((0.5, 2, 0.05)), ulna.pose((0.6, 0, 0.95)))
    left[0], right[0] = 1.0, -1.0
    plan = panda.plan(left, right, world)
    motion = plan.trajectory(acceleration=3.0, **options)
    message = motion.to_ros(period=period)
    t, n = times_of(message, names), len(plan.path)
    assert motion.stops == n - 2 > 0
    assert (np.diff(t) <= min(period, motion.duration) + 1e-9).all()
    for q in plan.path[1:-1]:
        (point,) = (point for point in message.points if np.abs(np.array(point.positions) - q).max() < 1e-9)
        assert point.velocities == point.accelerations == [0.0] * 7
    assert period < 1 or len(message.points) == n


def test_a_plan_that_does_not_move_is_one_point(panda, names):
    message = panda.plan(panda.home, panda.home).trajectory(acceleration=3.0).to_ros()
    assert times_of(message, names).tolist() == [0.0]
    assert np.array_equal(message.points[0].positions, panda.home)


def test_without_ros_the_error_says_what_is_missing(motion, monkeypatch):
    monkeypatch.setitem(sys.modules, "trajectory_msgs", None)  # as if it were not installed, wherever this runs
    monkeypatch.delitem(sys.modules, "trajectory_msgs.msg", raising=False)
    with pytest.raises(MissingROSError, match=r"cannot import trajectory_msgs.*docs/ros.md.*to_csv needs none"):
        motion.to_ros()
    page = (Path(__file__).parents[2] / "docs" / "ros.md").read_text(encoding="utf-8")
    assert {"python3-trajectory-msgs", "ros-jazzy-trajectory-msgs"} <= set(re.findall(r"[\w-]+", page))
