"""A robot with narrower limits: whatever is asked of it keeps them, and none is ever wider than the description's."""

import copy
import pickle

import numpy as np
import pytest

import ulna
from ulna.errors import DescriptionError, DescriptionWarning, FileError, InputError, UnknownNameError
from ulna.reachability.model import robot_from_json, robot_to_json

ONE = {"panda_joint1": 0.4, "panda_joint4": -1.2}

MIMIC = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="j1" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="4"/></joint>
<joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
<limit lower="-4" upper="5"/><mimic joint="j1" multiplier="-2" offset="0.5"/></joint>
<joint name="turn" type="continuous"><parent link="c"/><child link="d"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
<limit velocity="3" effort="1"/></joint></robot>"""


@pytest.fixture(scope="module")
def narrow(panda):
    return panda.with_limits(lower={"panda_joint1": -0.4}, upper=ONE, velocity=1.0)


def pickled(robot):
    return pickle.loads(pickle.dumps(robot))  # noqa: S301 - what this test wrote


def pairs_of(robot):
    return [(pair.link_a, pair.link_b) for pair in robot.allowed_collisions]


def within(robot, q):
    return bool(((q >= robot.lower) & (q <= robot.upper)).all())


def test_a_number_an_array_and_names_narrow_the_limits(panda):
    assert np.array_equal(panda.with_limits(velocity=1.0).velocity_limits, np.ones(7))
    lower = panda.lower + np.linspace(0, 0.3, 7)
    narrow = panda.with_limits(lower=lower, upper=ONE)
    assert np.array_equal(narrow.lower, lower)
    expected = panda.upper.copy()
    expected[[0, 3]] = 0.4, -1.2
    assert np.array_equal(narrow.upper, expected)
    assert within(narrow, narrow.home)
    again = narrow.with_limits(upper={"panda_joint1": 0.3}, velocity={"panda_joint2": 0.5})
    assert again.upper[[0, 3]].tolist() == [0.3, -1.2]
    assert again.velocity_limits[1] == 0.5


def test_limits_of_continuous_joints_and_of_followers():
    """j2 = 0.5 - 2 j1: j2 <= 1.5 is j1 >= -0.5, j2 >= -2.5 is j1 <= 1.5, and j1 moves half as fast."""
    robot = ulna.load(MIMIC)
    narrow = robot.with_limits(lower={"j2": -2.5, "turn": -1.0}, upper={"j2": 1.5, "turn": 2.0}, velocity={"j2": 1.0})
    assert narrow.lower.tolist() == [-0.5, -1.0]
    assert narrow.upper.tolist() == [1.5, 2.0]
    assert narrow.velocity_limits.tolist() == [0.5, 3.0]
    again = ulna.load(narrow.to_urdf())
    assert np.allclose([again.lower, again.upper, again.velocity_limits], [narrow.lower, narrow.upper, narrow.velocity_limits])
    q = narrow.random(500, seed=0)
    T = robot.forward_kinematics(q)
    found = narrow.inverse_kinematics(T[:50], seed=0)
    assert within(narrow, found.q[found.success])


def test_soft_limits_are_limits_where_they_are_asked_for():
    safety = '<safety_controller k_velocity="1" soft_lower_limit="-1.5" soft_upper_limit="1"/>'
    robot = ulna.load(MIMIC.replace('velocity="4"/>', f'velocity="4"/>{safety}'))
    soft = robot.with_limits(lower=robot.soft_lower, upper=robot.soft_upper)
    assert (soft.lower[0], soft.upper[0]) == (-1.5, 1.0)
    assert np.isinf(soft.lower[1])  # a joint without a safety controller keeps its limits


@pytest.mark.parametrize(
    "change",
    [
        lambda robot: robot,
        copy.copy,
        copy.deepcopy,
        pickled,
        lambda robot: robot.with_tool(np.eye(4)),
        lambda robot: robot.with_attached("cup", ulna.Box((0.05, 0.05, 0.1)), np.eye(4)).without_attached("cup"),
        lambda robot: robot.with_allowed_collisions([("panda_link1", "panda_link7")]),
        lambda robot: robot_from_json(robot_to_json(robot, checked=True)),
        lambda robot: ulna.load(robot.to_urdf()),
        lambda robot: ulna.Robot.from_dh(robot.dh()),
    ],
)
def test_changed_copied_and_pickled_robots_keep_them(narrow, change):
    changed = change(narrow)
    assert np.array_equal(changed.lower, narrow.lower)
    assert np.array_equal(changed.upper, narrow.upper)
    assert np.array_equal(changed.velocity_limits, narrow.velocity_limits)
    assert not changed.upper.flags.writeable


def test_inverse_kinematics_plans_motions_servos_and_samples_keep_them(panda, narrow):
    q = narrow.random(200, seed=1)
    assert within(narrow, q)
    T = panda.forward_kinematics(panda.random(100, seed=2))
    found = narrow.inverse_kinematics(T, seed=0)
    assert within(narrow, found.q[found.success])
    assert found.success.sum() < 60
    T = panda.forward_kinematics(q)
    found = narrow.inverse_kinematics(T[:50], seed=0)
    assert found.success.mean() > 0.9
    assert within(narrow, found.q[found.success])
    every = narrow.all_solutions(T[:5])
    assert every.valid.any()
    assert within(narrow, every.q[every.valid])
    T_path = np.repeat(panda.forward_kinematics(narrow.home)[None], 20, axis=0)
    T_path[:, 1, 3] += np.linspace(0, 0.15, 20)
    assert within(narrow, narrow.follow(T_path, narrow.home).q)

    plan = narrow.plan(q[0], q[1])
    assert within(narrow, plan.path)
    motion = plan.trajectory(limits="franka")  # whose velocities are 2.175 and 2.61
    moment = motion.at(np.linspace(0, motion.duration, 5001))
    assert within(narrow, moment.q)
    assert np.abs(moment.qd).max() <= 1.0
    assert motion.check("franka")
    with pytest.raises(InputError, match=r"goal: 0\.9 of joint 'panda_joint1' is outside its limits, -0\.4 to 0\.4"):
        narrow.plan(narrow.home, narrow.home + 0.9 * np.eye(7)[0])

    servo = narrow.servo(acceleration=10.0)
    servo.start(narrow.home)
    commands = np.array([servo.step(velocity=[2.0, 0, 0, 0, 0, 0, 0]).q for _ in range(900)])
    assert (commands <= narrow.upper + 1e-12).all()
    assert commands[-1, 0] > 0.399
    assert np.abs(np.diff(commands, axis=0)).max() <= 1e-3


def test_accelerations_and_jerks_are_those_of_motions_and_servos(panda):
    robot = panda.with_limits(acceleration=2.0, jerk=50.0)
    motion = robot.trajectory([robot.home, robot.home + 0.2])
    assert motion.limits_jerk
    assert motion.check(acceleration=2.0, jerk=50.0)
    assert robot.trajectory([robot.home, robot.home + 0.2], acceleration=9.0, jerk=900.0).check(acceleration=2.0, jerk=50.0)
    assert robot.servo().limits.acceleration.max() <= 2.0
    assert robot.servo(acceleration=1.0, jerk=1e4).limits.jerk.max() <= 50.0
    with pytest.raises(InputError, match=r"acceleration: none is given, and the robot has none above 0 for 'panda_joint2', "):
        panda.with_limits(acceleration={"panda_joint1": 1.0}).trajectory([robot.home, robot.home + 0.2])
    with pytest.raises(InputError, match="acceleration: none is given"):
        panda.servo()


def test_what_may_touch_is_found_in_the_range_of_the_description():
    """In a range so narrow that two links always touch they would count as made to touch, and be checked no more."""
    shape = '<collision><geometry><box size="0.4 0.1 0.1"/></geometry></collision>'
    links = "".join(f'<link name="l{k}">{shape}</link>' for k in range(3))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0.45 0 0"/>'
        '<axis xyz="0 0 1"/><limit lower="-3.1" upper="3.1" velocity="1" effort="1"/></joint>'
        for k in range(2)
    )
    text = f'<robot name="r">{links}{joints}</robot>'
    robot = ulna.load(text)
    folded = [0.0, 3.0]
    narrow = robot.with_limits(lower={"j1": 2.9})
    for one in (robot, narrow, pickled(narrow)):
        assert one.in_collision(folded) == robot.in_collision(folded)
        assert pairs_of(one) == pairs_of(robot)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"lower": -2.9}, r"lower: -2.9 is the lower limit of panda_joint1, 0.0027 wider than its own of -2.8973"),
        (
            {"upper": {"panda_joint4": 0.1}},
            "upper: 0.1 is the upper limit of panda_joint4, 0.1698 wider than its own of",
        ),
        ({"velocity": 3.0}, "velocity: 3 is the velocity limit of panda_joint1, 0.825 wider than its own of 2.175"),
        ({"lower": -np.inf}, "lower: -inf is the lower limit of panda_joint1, inf wider"),
        ({"lower": {"panda_joint1": 1.0}, "upper": {"panda_joint1": 0.5}}, "lower: panda_joint1 would have the range 1 to 0.5"),
        ({"upper": {"panda_joint1": -2.8973}}, "upper: panda_joint1 would have the range -2.8973 to -2.8973, which is empty"),
        ({"lower": [0.0, 0.0]}, "lower: .* a number, or 7 of them, is expected"),
        ({"lower": np.nan}, "lower: nan; a number"),
        ({"velocity": 0.0}, "velocity: 0.0; numbers above 0"),
        ({"velocity": {"panda_joint1": -1.0}}, r"velocity\['panda_joint1'\]: -1.0; a number above 0"),
        ({"limits": "franka"}, "limits: 'franka'; a file joint_limits.yaml, or the mapping of one"),
        ({"limits": 7}, "limits: 7"),
        (
            {"limits": {"joint_limits": {"panda_joint1": {"max_position": 3.0}}}},
            "limits: 3 is the upper limit of panda_joint1, 0.1027 wider",
        ),
    ],
)
def test_what_is_wider_or_no_limit_is_refused_by_joint_and_amount(panda, given, says):
    with pytest.raises(InputError, match=says):
        panda.with_limits(**given)


def test_unknown_joints_and_files_are_refused(panda, tmp_path):
    with pytest.raises(UnknownNameError, match="panda_joint'; did you mean"):
        panda.with_limits(lower={"panda_joint": -1.0})
    with pytest.raises(FileError):
        panda.with_limits(tmp_path / "none.yaml")
    with pytest.raises(DescriptionError, match="limits: has no mapping joint_limits"):
        panda.with_limits({"a": 1})


def test_a_limit_that_was_written_with_fewer_digits_is_that_of_the_description(panda):
    narrow = panda.with_limits(upper={"panda_joint1": panda.upper[0] + 3e-5})
    assert narrow.upper[0] == panda.upper[0]


def test_scaling_factors_of_a_file_are_named_since_they_are_no_limits(panda):
    document = {"default_velocity_scaling_factor": 0.1, "joint_limits": {"panda_joint1": {"max_velocity": 1.0}}}
    with pytest.warns(DescriptionWarning, match="default scaling factors are not limits"):
        narrow = panda.with_limits(document)
    assert narrow.velocity_limits[0] == 1.0
