"""Limits from a joint_limits.yaml as MoveIt has it."""

import numpy as np
import pytest

from ulna.errors import DescriptionError, DescriptionWarning, FileError, InputError
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
    assert limits.scaling == (0.1, 1.0)


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
        ("joint_limits: {a: {max_position: .inf}}", "a: max_position is inf; a finite number"),
        ("joint_limits: {a: {min_position: up}}", "a: min_position is 'up'; a finite number"),
        (
            "joint_limits: {a: {min_position: 2, max_position: 1}}",
            "min_position is 2, and max_position is 1: a range is expected",
        ),
        ("joint_limits: {a: {min_velocity: 0.5, max_velocity: 1}}", "min_velocity is 0.5; one below 0 is expected"),
        ("joint_limits: {a: {has_position_limits: maybe}}", "has_position_limits is 'maybe'; true or false"),
        ("{default_velocity_scaling_factor: 2, joint_limits: {a: {}}}", "default_velocity_scaling_factor is 2; a number above 0"),
        ("{x: {joint_limits: {a: {max_jerk: 1}}}, y: {joint_limits: {a: {}}}}", "several mappings joint_limits, .*: under x, y"),
    ],
)
def test_what_is_none_of_limits_is_refused_with_its_file(file, text, says):
    with pytest.raises(DescriptionError, match=rf"joint_limits\.yaml: .*{says}"):
        read_joint_limits(file(text), ["a", "b"])


def test_a_file_that_is_not_there_or_too_large_is_a_file_error(file, tmp_path):
    with pytest.raises(FileError, match="no such file"):
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


def test_positions_of_a_file_are_limits_of_plans_motions_and_checks(file, panda):
    path = file("joint_limits: {panda_joint1: {has_position_limits: true, min_position: -0.5, max_position: 0.5}}")
    far, near = panda.home.copy(), panda.home.copy()
    far[0], near[0] = 1.5, 0.5
    motion = panda.plan(panda.home, far).trajectory(limits="franka")
    check = motion.check(path)
    assert (check.within, check.joint, check.quantity, check.limit) == (False, "panda_joint1", "position", 0.5)
    assert check.value == pytest.approx(1.5)
    assert "the position of panda_joint1 is 1.5 at " in str(check)
    with pytest.raises(InputError, match=r"limits: the plan has panda_joint1 at 1.5, 1 beyond its upper limit of 0.5; plan with"):
        panda.plan(panda.home, far).trajectory(limits=path, acceleration=2.0)
    with pytest.raises(InputError, match=r"q_path: point 1 has panda_joint1 at 1.5, 1 beyond its upper limit of 0.5"):
        panda.trajectory([panda.home, far], limits=path, acceleration=2.0)
    kept = panda.plan(panda.home, near).trajectory(limits=path, acceleration=2.0)
    assert kept.check(path)
    assert kept.limits["position"][1][0] == 0.5
    assert panda.with_limits(path).upper[0] == 0.5


@pytest.mark.parametrize(
    ("joint", "expected"),
    [
        ("{has_position_limits: false, min_position: -0.5, max_position: 0.5}", (-np.inf, np.inf)),
        ("{has_position_limits: true}", (-np.inf, np.inf)),  # those of the description
        ("{max_position: !degrees 90}", (-np.inf, np.pi / 2)),
        ("{min_position: -1}", (-1.0, np.inf)),
    ],
)
def test_positions_count_where_the_file_says_that_there_are_some(file, joint, expected):
    limits = read_joint_limits(file(f"joint_limits: {{a: {joint}}}"), ["a"])
    assert (limits.lower[0], limits.upper[0]) == expected


def test_the_narrower_direction_of_a_magnitude_and_slowing_down_count(file):
    text = "{min_velocity: -0.5, max_velocity: 1, max_acceleration: 3, max_deceleration: 2, min_jerk: -7}"
    limits = read_joint_limits(file(f"joint_limits: {{a: {text}}}"), ["a"])
    assert (limits.velocity[0], limits.acceleration[0], limits.jerk[0]) == (0.5, 2.0, 7.0)


def test_a_key_that_is_not_known_is_named_in_a_warning(file):
    text = "joint_limits: {a: {max_velocity: 1, max_effort: 5, soft_lower_limit: -1, maximum_velocity: 2}, c: {other: 1}}"
    with pytest.warns(DescriptionWarning, match=r"a.soft_lower_limit, a.maximum_velocity: unknown and ignored"):
        read_joint_limits(file(text), ["a"])


NESTED = """
/**/move_group:
  ros__parameters:
    robot_description_planning:
      default_acceleration_scaling_factor: 0.5
      joint_limits:
        a: {max_velocity: 1.0, max_acceleration: 2.0, min_position: -1}
"""


DOTTED = """
/**:
  ros__parameters:
    robot_description_planning.joint_limits.a.max_velocity: 1.0
    robot_description_planning.joint_limits.a.max_acceleration: 2.0
    robot_description_planning.joint_limits.a.min_position: -1
"""


@pytest.mark.parametrize(
    "text",
    [
        NESTED,
        "/**:\n  ros__parameters:\n    joint_limits: {a: {max_velocity: 1.0, max_acceleration: 2.0, min_position: -1}}",
        "robot_description_planning: {joint_limits: {a: {max_velocity: 1.0, max_acceleration: 2.0, min_position: -1}}}",
        DOTTED,
        "x: &x {joint_limits: {a: {max_velocity: 1.0, max_acceleration: 2.0, min_position: -1}}}\ny: *x",
    ],
)
def test_parameters_of_a_ros_2_node_are_read(file, text):
    limits = read_joint_limits(file(text), ["a"])
    assert (limits.velocity[0], limits.acceleration[0], limits.lower[0]) == (1.0, 2.0, -1.0)
    assert limits.scaling == (1.0, 0.5 if text == NESTED else 1.0)


def test_a_motion_takes_the_shares_of_a_file_and_a_check_does_not(file, panda):
    rows = "\n".join(f"  panda_joint{k}: {{max_velocity: 1.0, max_acceleration: 3.0}}" for k in range(1, 8))
    path = file(f"default_velocity_scaling_factor: 0.5\ndefault_acceleration_scaling_factor: 0.25\njoint_limits:\n{rows}\n")
    goal = panda.home.copy()
    goal[0] += 1.0
    plan = panda.plan(panda.home, goal)
    motion = plan.trajectory(limits=path)
    assert motion.limits["velocity"][1].tolist() == [0.5] * 7
    assert motion.limits["acceleration"][1].tolist() == [0.75] * 7
    check = motion.check(path)
    assert check
    assert check.value / check.limit == pytest.approx(0.5, rel=1e-3)
    assert plan.trajectory(limits=path, velocity=1.0, acceleration=3.0).limits["velocity"][1].tolist() == [1.0] * 7


def test_limits_of_one_joint_are_enough_where_the_rest_is_given(file, panda):
    path = file("joint_limits: {panda_joint1: {max_velocity: 0.5, max_acceleration: 1.0}}")
    motion = panda.trajectory([panda.home, panda.home + 0.1], limits=path, acceleration=1.0)
    assert motion.check(path)
    assert not panda.trajectory([panda.home, panda.home + 0.1], acceleration=5.0).check(path)


def test_the_mapping_of_a_file_is_taken_as_the_file_is(panda):
    document = {"joint_limits": {"panda_joint1": {"max_velocity": 0.3}}}
    motion = panda.trajectory([panda.home, panda.home + 0.2], limits=document, acceleration=5.0)
    assert motion.limits["velocity"][1][0] == 0.3
    assert motion.check(document)
