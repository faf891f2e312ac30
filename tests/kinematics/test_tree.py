"""The kinematic tree that the model lays out: axes in every direction, and what drives which joint."""

import numpy as np
import pytest

import formulas
import robots
import ulna
from assertions import assert_close
from ulna.description.robot_description import Description, Joint, JointType, Link, Mimic
from ulna.errors import DescriptionError


def pair_with_mimic(leader, follower):
    """A joint ``j`` of one type, and behind it a joint ``k`` of another that follows it."""
    joints = (
        Joint("j", JointType(leader), "a", "b", robots.place(0), robots.Z),
        Joint("k", JointType(follower), "b", "c", robots.place(1), robots.Z, mimic=Mimic("j", 2.0, 0.5)),
    )
    return Description("pair", tuple(map(Link, "abc")), joints)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("tilt", [0.3, 1e-2, 1e-3, 1e-4, 1e-5, 1.5e-6, 1e-6, 1e-7, 1e-9, 1e-12, 0.0])
def test_an_axis_almost_along_z_is_that_axis(side, tilt):
    for kind in ("revolute", "prismatic"):
        description = robots.two_links(kind, robots.unit(tilt, -tilt / 3, side), origin=robots.place(1))
        found = ulna.Robot(description).forward_kinematics([2.0])
        assert_close(found, formulas.link_pose(description, [2.0], "b"), atol=1e-14)


@pytest.mark.parametrize("axis", [*np.eye(3), *-np.eye(3), robots.unit(1, 1, 1), robots.unit(-1, 2, -3)])
@pytest.mark.parametrize("kind", ["revolute", "prismatic", "planar"])
def test_every_direction_of_an_axis_is_that_direction(rng, kind, axis):
    description = robots.two_links(kind, axis, origin=robots.place(2))
    q = rng.uniform(-2, 2, formulas.N_POSITIONS[kind])
    found = ulna.Robot(description).forward_kinematics(q)
    assert_close(found, formulas.link_pose(description, q, "b"), atol=1e-14)


@pytest.mark.parametrize("axis", [robots.Z, robots.X, robots.unit(1, 2, 3)])
def test_the_axis_of_a_floating_joint_means_nothing(rng, axis):
    q = rng.uniform(-1, 1, 6)
    found = ulna.Robot(robots.two_links("floating", axis)).forward_kinematics(q)
    assert_close(found, formulas.from_rpy(q[:3], q[3:]), atol=1e-14)


@pytest.mark.parametrize("follower", ["planar", "floating"])
@pytest.mark.parametrize("leader", ["revolute", "fixed"])
def test_a_joint_of_several_positions_cannot_mimic_one(leader, follower):
    with pytest.raises(DescriptionError, match="'k'"):
        ulna.Robot(pair_with_mimic(leader, follower))


@pytest.mark.parametrize("leader", ["planar", "floating"])
def test_a_joint_of_several_positions_cannot_be_mimicked(leader):
    with pytest.raises(DescriptionError, match=f"joint 'k' mimics 'j', a {leader} joint: no single number to follow"):
        ulna.Robot(pair_with_mimic(leader, "revolute"))


@pytest.mark.parametrize("follower", ["revolute", "prismatic"])
def test_a_mimic_of_a_fixed_joint_is_constant_at_its_offset(follower):
    description = pair_with_mimic("fixed", follower)
    robot = ulna.Robot(description)
    assert robot.n_dof == 0
    assert_close(robot.forward_kinematics([]), formulas.link_pose(description, [], "c"), atol=1e-15)


def test_a_mimic_of_a_fixed_joint_moves_nothing_of_others(rng):
    joints = (
        *pair_with_mimic("fixed", "revolute").joints,
        Joint("l", JointType.REVOLUTE, "c", "d", robots.place(2), robots.X),
    )
    description = Description("three", tuple(map(Link, "abcd")), joints)
    J = ulna.Robot(description).jacobian([0.7])
    assert_close(J, formulas.jacobian(description, [0.7], "d"), atol=1e-10)


@pytest.mark.parametrize("q", [1e6, -1e6, 999_000.123, 0.3])
def test_the_fastest_mimic_turns_by_a_rotation_as_exact_as_the_angle_that_it_follows(q):
    joint = "<joint name='{}' type='continuous'><parent link='{}'/><child link='{}'/>{}</joint>"
    links = "".join(f"<link name='{name}'/>" for name in "abc")
    follower = joint.format("k", "b", "c", "<mimic joint='j' multiplier='1e6' offset='1e6'/>")
    robot = ulna.load(f"<robot name='m'>{links}{joint.format('j', 'a', 'b', '')}{follower}</robot>")
    R = robot.forward_kinematics([q])[:3, :3]
    assert_close(R @ R.T, np.eye(3), atol=1e-15)
    assert R[1, 1] == pytest.approx(np.cos(q + 1e6 * q + 1e6), abs=1e-3)


def test_mimics_are_no_entries_of_q_and_follow_through_each_other():
    robot = ulna.Robot(robots.every_joint())
    assert robot.joint_names == ("shoulder", "table", "slide", "wheel", "float", "rotor joint")
    assert robot.joint_slices == tuple(slice(*s) for s in [(0, 1), (1, 4), (4, 5), (5, 6), (6, 12), (12, 13)])
    expected = formulas.joint_positions(robots.every_joint(), np.arange(13.0))
    assert expected["finger"] == 0.25 * (-0.5 * 0 + 0.3) - 0.05
    assert_close(robot.link_poses(np.arange(13.0)), formulas.link_poses(robots.every_joint(), np.arange(13.0)), atol=1e-13)


def test_limits_stand_where_their_joints_do():
    robot = ulna.Robot(robots.every_joint())
    assert list(robot.lower[[0, 4, 12]]) == [-2.0, -0.2, -2.0]
    assert list(robot.upper[[0, 4, 12]]) == [1.8, 0.4, 2.5]  # wrist = -0.5 shoulder + 0.3, its finger stands at -0.2 at least
    assert np.isinf(np.delete(robot.lower, [0, 4, 12])).all()
    assert list(robot.velocity_limits[[0, 4, 5]]) == [1.5, 0.3, np.inf]
