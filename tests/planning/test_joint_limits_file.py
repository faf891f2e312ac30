"""Limits from a joint_limits.yaml as MoveIt has it."""

import numpy as np
import pytest

from ulna.errors import DescriptionError, FileError
from ulna.planning.motion_limits import read_joint_limits

FILE = """
default_velocity_scaling_factor: 0.1
joint_limits:
  a:
    has_velocity_limits: true
    max_velocity: !degrees 180
    has_acceleration_limits: true
    max_acceleration: 3.75
    has_jerk_limits: false
    max_jerk: 0
  b: {max_acceleration: !radians 2, has_velocity_limits: false, max_velocity: 7.0}
  finger: {max_velocity: 0.1}
"""


@pytest.fixture
def file(tmp_path):
    def write(text):
        path = tmp_path / "joint_limits.yaml"
        path.write_text(text)
        return path

    return write


def test_limits_are_read_by_joint(file):
    limits = read_joint_limits(file(FILE), ["b", "a"])
    assert np.array_equal(limits.velocity, [np.nan, np.pi], equal_nan=True)
    assert limits.acceleration.tolist() == [2.0, 3.75]
    assert limits.jerk is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("joint_limits: [", "not YAML"),
        ("joint_limits: {a: {max_velocity: !degrees x}}", "not YAML"),
        ("joint_limits: {a: {max_velocity: !degrees [1]}}", "not YAML"),
        ("joint_limits: {a: !!python/object/apply:os.getcwd []}", "not YAML"),
        ("other: 1", "no mapping joint_limits"),
        ("[1, 2]", "no mapping joint_limits"),
        ("joint_limits: {c: {max_velocity: 1}}", "has none of the joints a, b; it has c"),
        ("joint_limits: {a: 3}", "a mapping is expected"),
        ("joint_limits: {a: {max_velocity: -1}}", "max_velocity is -1; a number above 0"),
        ("joint_limits: {a: {max_velocity: fast}}", "max_velocity is 'fast'"),
        ("joint_limits: {a: {has_velocity_limits: true}}", "max_velocity is None"),
        ("joint_limits: {a: {max_jerk: true}}", "max_jerk is True"),
        ("joint_limits: {a: {max_jerk: 5}, b: {max_velocity: 1}}", "the jerk of some joints, but not of b"),
    ],
)
def test_what_is_none_of_limits_is_refused_with_its_file(file, text, says):
    with pytest.raises(DescriptionError, match=rf"joint_limits\.yaml: .*{says}"):
        read_joint_limits(file(text), ["a", "b"])


def test_a_file_that_is_not_there_or_too_large_is_a_file_error(file, tmp_path):
    with pytest.raises(FileError, match="No such file"):
        read_joint_limits(tmp_path / "none.yaml", ["a"])
    with pytest.raises(FileError, match="bytes"):
        read_joint_limits(file("#" * 1_000_001), ["a"])


def test_a_plan_and_a_check_take_a_file(file, panda):
    rows = "\n".join(f"  panda_joint{k}: {{max_velocity: 1.0, max_acceleration: 3.0, max_jerk: 100.0}}" for k in range(1, 8))
    path = file(f"joint_limits:\n{rows}\n")
    goal = panda.home.copy()
    goal[:3] += 0.5
    motion = panda.plan(panda.home, goal).trajectory(limits=path)
    assert motion.check(path)
    assert motion.check(str(path))
    assert motion.check(velocity=1.0, acceleration=3.0, jerk=100.0)
    assert not motion.check(jerk=90.0)


def test_a_velocity_that_a_file_does_not_state_is_that_of_the_description(file, panda):
    goal = panda.home.copy()
    goal[0] += 1.0
    fast = panda.plan(panda.home, goal).trajectory(velocity=50.0, acceleration=200.0)
    check = fast.check(file("joint_limits: {panda_joint1: {has_acceleration_limits: false}}"))
    assert (check.within, check.quantity, check.limit) == (False, "velocity", panda.velocity_limits[0])
