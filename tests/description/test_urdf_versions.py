"""What URDF 1.1 and 1.2 added: quaternions, and limits of acceleration and jerk; and what is not read is said."""

import numpy as np
import pytest

import ulna
from ulna.description.pose import quaternion_from_matrix

TEXT = """<robot name="arm" {robot}>
<link name="a"><collision>{origin}<geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<link name="b"/><link name="c"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>{origin}<axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="2" effort="1" {first}/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="2" effort="1" {second}/>{inside}</joint></robot>"""
NOTHING = {"robot": 'version="1.2"', "origin": "", "first": "", "second": "", "inside": ""}


def text(**parts):
    return TEXT.format(**{**NOTHING, **parts})


def turned(x, y, z, w):
    """A rotation by a quaternion, from v + 2 u x (u x v + w v)."""
    u = np.array([x, y, z]) / np.linalg.norm([x, y, z, w])
    w = w / np.linalg.norm([x, y, z, w])
    return np.array([v + 2 * np.cross(u, np.cross(u, v) + w * v) for v in np.eye(3)]).T


@pytest.mark.parametrize("version", ["1.1", "1.2"])
def test_a_quaternion_turns_a_joint_and_a_shape_as_its_own_formula_does(version, rng):
    for xyzw in rng.normal(size=(5, 4)):
        words = " ".join(map(repr, xyzw.tolist()))
        robot = ulna.load(text(robot=f'version="{version}"', origin=f'<origin xyz="1 2 3" quat_xyzw="{words}"/>'))
        T = robot.forward_kinematics([0.0, 0.0], link="b")
        assert np.abs(T[:3, :3] - turned(*xyzw)).max() < 1e-14
        assert T[:3, 3].tolist() == [1, 2, 3]
        assert np.array_equal(robot.description.links[0].collisions[0].pose, robot.description.joints[0].origin)


def test_a_shape_that_a_quaternion_turns_touches_what_it_touches_there():
    upright = text(origin='<origin quat_xyzw="0 0.7071067811865476 0 0.7071067811865476"/>')
    world = ulna.World()
    world.add("ball", ulna.Sphere(0.05), ulna.pose((0, 0, 0.45)))
    assert ulna.load(upright).in_collision([0, 0], world)
    assert not ulna.load(text()).in_collision([0, 0], world)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"origin": '<origin rpy="0 0 1" quat_xyzw="0 0 0 1"/>'}, "both rpy and quat_xyzw"),
        ({"origin": '<origin quat_xyzw="0 0 0 0"/>'}, "length 0"),
        ({"origin": '<origin quat_xyzw="0 0 1"/>'}, "4 finite numbers"),
        ({"origin": '<origin quat_xyzw="0 0 1 1"/>', "robot": ""}, r'is of URDF 1\.1.*write <robot version="1\.1">'),
        ({"origin": '<origin quat_xyzw="0 0 1 1"/>', "robot": 'version="1.0"'}, "is of URDF 1.1"),
        ({"robot": 'version="1.3"'}, "is URDF 1.3; versions up to 1.2 are read"),
        ({"robot": 'version="2.0"'}, "is URDF 2.0"),
        ({"first": 'acceleration="-1"'}, "of at least 0"),
        ({"first": 'jerk="fast"'}, "not numbers"),
    ],
)
def test_what_is_ambiguous_or_of_an_unknown_version_is_refused(parts, message):
    with pytest.raises(ulna.DescriptionError, match=message):
        ulna.load(text(**parts))


def test_a_joint_of_urdf_1_2_states_both_of_its_limits():
    with pytest.raises(ulna.DescriptionError, match="its <limit> has no 'lower'"):
        ulna.load(text().replace('lower="-1"', "", 1))
    assert ulna.load(text(robot="").replace('lower="-1"', "", 1)).lower.tolist() == [0, -1]


def test_accelerations_and_jerks_are_read_and_infinite_where_there_is_none():
    robot = ulna.load(text(first='acceleration="3" deceleration="2" jerk="40"', second='acceleration="5"'))
    assert robot.acceleration_limits.tolist() == [2, 5]
    assert robot.jerk_limits.tolist() == [40, np.inf]
    assert ulna.load(text()).acceleration_limits.tolist() == [np.inf, np.inf]
    assert ulna.load(text(robot="", first='acceleration="3"')).acceleration_limits.tolist() == [3, np.inf]
    follower = ulna.load(text(second='acceleration="6" jerk="8"', inside='<mimic joint="j" multiplier="-2"/>'))
    assert (follower.acceleration_limits.tolist(), follower.jerk_limits.tolist()) == ([3], [4])


def test_a_description_that_is_written_keeps_them_in_a_version_that_has_them():
    robot = ulna.load(text(first='acceleration="3" deceleration="2" jerk="40"')).with_tool(ulna.pose((0, 0, 0.1)))
    assert 'version="1.2"' in robot.to_urdf()
    again = ulna.load(robot.to_urdf())
    assert [joint.limits for joint in again.description.joints] == [joint.limits for joint in robot.description.joints]
    capsule = ulna.load(text(robot="").replace('<box size="1 0.1 0.1"/>', '<capsule radius="1" length="1"/>'))
    assert 'version="1.1"' in capsule.with_tool(ulna.pose()).to_urdf()


def test_a_motion_and_a_servo_keep_the_accelerations_of_the_description_unless_others_are_given():
    robot = ulna.load(text(first='acceleration="3" deceleration="2" jerk="40"', second='acceleration="5"'))
    motion = robot.trajectory([[0, 0], [0.5, 0.3]])
    t = np.linspace(0, motion.duration, 2001)
    qdd = np.gradient(np.gradient(motion.at(t).q, t, axis=0), t, axis=0)[2:-2]
    assert (np.abs(qdd).max(axis=0) <= np.array([2, 5]) * 1.001).all()
    assert np.abs(np.diff(qdd[:, 0]) / np.diff(t)[2:-2]).max() <= 40 * 1.001
    faster = robot.trajectory([[0, 0], [0.5, 0.3]], acceleration=20, jerk=1e4)
    assert faster.duration < motion.duration
    servo = robot.servo(rate=500)
    servo.start([0, 0])
    commands = np.array([servo.step(twist=[0, 0.3, 0, 0, 0, 0]).q for _ in range(100)])
    assert np.abs(np.diff(commands, 2, axis=0)[:, 0]).max() * 500**2 <= 2 * 1.001
    above = robot.servo(rate=500, acceleration=50)
    above.start([0, 0])
    assert np.array_equal(commands, [above.step(twist=[0, 0.3, 0, 0, 0, 0]).q for _ in range(100)])


def test_a_joint_without_an_acceleration_has_to_be_given_one():
    robot = ulna.load(text(first='acceleration="3"'))
    for ask in (lambda: robot.trajectory([[0, 0], [0.5, 0.3]]), robot.servo):
        with pytest.raises(ulna.InputError, match=r"^acceleration: .*k.*give acceleration="):
            ask()


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"inside": '<position_based_velocity_limits a="1"/>'}, "7: joint 'k': <position_based_velocity_limits> in <joint>"),
        ({"inside": "<orgin/>"}, "did you mean <origin>"),
        ({"second": 'uper="1"'}, "attribute 'uper' of <limit> is not known, and left out; did you mean 'upper'"),
        ({"inside": '<loop/><frame name="f"/>'}, r"<loop> in <joint> is not read \(2 such sentences: ulna inspect\)"),
        ({"robot": 'version="1"'}, "version '1' is not two numbers"),
        ({"first": 'acceleration="0"', "robot": ""}, "acceleration '0' is not a number above 0"),
    ],
)
def test_load_says_what_is_not_read_and_may_matter(parts, message):
    with pytest.warns(ulna.DescriptionWarning, match=message):
        ulna.load(text(**parts))
    warned = [one for one in ulna.inspect(text(**parts)).findings if one.severity == ulna.Severity.WARNING]
    assert len(warned) == (2 if "2 such" in message else 1)


def test_what_other_programs_read_is_a_note_and_load_is_silent():
    others = text(inside='<dynamics damping="1"/><calibration rising="1"/>').replace(
        "</robot>", '<gazebo reference="a"><gravity/></gazebo><transmission/><ros2_control/></robot>'
    )
    ulna.load(others)  # warnings are errors here
    assert not [one for one in ulna.inspect(others).findings if one.severity == ulna.Severity.WARNING]


def test_a_range_of_a_continuous_joint_that_is_not_used_is_said_unless_it_is_a_turn():
    limited = text().replace('"revolute"', '"continuous"', 1)
    with pytest.warns(ulna.DescriptionWarning, match="lower and upper of a continuous joint are not used"):
        assert np.isinf(ulna.load(limited).upper[0])
    ulna.load(limited.replace('lower="-1" upper="1"', 'lower="-6.2832" upper="6.2832"', 1))


@pytest.mark.parametrize(("lower", "findings"), [(-0.8757, 0), (-0.85, 0), (-0.1, 1), (-0.001, 1), (0.0, 1)])
def test_a_follower_that_narrows_its_leader_has_a_finding(lower, findings):
    gripper = text(first='acceleration="1"', second='acceleration="1"', inside='<mimic joint="j" multiplier="-1"/>').replace(
        'lower="-1" upper="1"', 'lower="0" upper="0.8757"'
    )
    gripper = gripper[::-1].replace('lower="0"'[::-1], f'lower="{lower}"'[::-1], 1)[::-1]
    found = [one for one in ulna.inspect(gripper).findings if "mimics" in one.message]
    assert [one.severity for one in found] == [ulna.Severity.WARNING] * findings


def test_quaternions_and_angles_of_one_turn_are_the_same_robot(rng):
    rpy = rng.uniform(-1.5, 1.5, 3)
    w, *xyz = quaternion_from_matrix(ulna.pose(rpy=rpy)[:3, :3])
    words = " ".join(map(repr, [*map(float, xyz), float(w)]))
    by_angles = ulna.load(text(origin=f'<origin rpy="{" ".join(map(repr, rpy.tolist()))}"/>'))
    assert ulna.compare(by_angles, ulna.load(text(origin=f'<origin quat_xyzw="{words}"/>'))).same
