"""Two arms on one base: a search for the hand of one leaves the other alone."""

from dataclasses import replace

import numpy as np
import pytest

import robots
from ik_methods import valid_solutions
from ulna import Robot
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link, Mimic

OTHER = slice(0, 6)  # the entries of q that drive the arm that nobody asks about


def arm_named(side, limits):
    """The joints of a UR5, with the side before every name but the base's."""
    for joint in Robot.from_dh(robots.UR5, convention="standard", limits=limits).description.joints:
        parent = "base" if joint.parent == "base" else f"{side} {joint.parent}"
        yield replace(joint, name=f"{side} {joint.name}", parent=parent, child=f"{side} {joint.child}")


@pytest.fixture(scope="module")
def arms():
    limits = [(-np.pi, np.pi)] * 6
    joints = (*arm_named("other", limits), *arm_named("asked", limits))
    return Robot(Description("two arms", (Link("base"), *(Link(joint.child) for joint in joints)), joints))


@pytest.fixture(scope="module")
def targets(arms):
    q = np.random.default_rng(61).uniform(arms.lower, arms.upper, (50, 12))
    return arms.forward_kinematics(q, link="asked link6")


def test_the_other_arm_stays_where_it_was_from_whatever_start(arms, targets):
    stand = np.random.default_rng(62).uniform(arms.lower, arms.upper)
    for options, where in (({}, arms.home), ({"q_seed": stand}, stand)):
        one = np.array([arms.inverse_kinematics(T, link="asked link6", **options).q for T in targets])
        many = arms.inverse_kinematics(targets, link="asked link6", **options)
        ranked = arms.inverse_kinematics(targets, link="asked link6", rank="manipulability", **options)
        for q in (one, many.q, ranked.q):
            np.testing.assert_array_equal(q[:, OTHER], np.tile(where[OTHER], (50, 1)))
        assert many.success.all()


def test_a_start_that_is_not_the_seed_is_replayed_with_the_other_arm_at_the_seed(arms, targets):
    for T in targets:
        result = arms.inverse_kinematics(T, link="asked link6", trace=True)
        assert result.trace[-1, :2] == pytest.approx([result.position_error, result.rotation_error], abs=1e-9)


def test_a_leader_whose_follower_it_does_not_move_stays_too():
    base, tip = Robot.from_dh([(0, 0, 0, 0), (1.0, 0, 0, 0), (1.0, 0, 0, 0)]).description, Link("tip")
    leader = Joint("leader", JointType.REVOLUTE, "base", "away", np.eye(4), robots.Z, Limits(-1, 1))
    follower = replace(leader, name="follower", parent="link3", child="tip", mimic=Mimic("leader", 0.0, 0.5))
    arm = Robot(replace(base, links=(*base.links, Link("away"), tip), joints=(*base.joints, leader, follower)))
    assert arm.joint_names == ("joint1", "joint2", "joint3", "leader")
    T = arm.forward_kinematics(np.random.default_rng(63).uniform(-1, 1, (50, 4)), link="tip")
    result = arm.inverse_kinematics(T, link="tip")
    assert result.success.all()
    np.testing.assert_array_equal(result.q[:, 3], np.zeros(50))
    assert (arm.manipulability(result.q, link="tip") > 0.0).any()


def test_every_branch_of_the_arm_is_found_once(arms):
    alone = Robot.from_dh(robots.UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6)
    q = [0.3, -1.2, 1.5, -0.7, 1.1, 0.4]
    branches = valid_solutions(alone, alone.forward_kinematics(q))
    found = valid_solutions(arms, alone.forward_kinematics(q), link="asked link6")
    assert len(found) == len(branches) == 8
    np.testing.assert_array_equal(found[:, OTHER], np.tile(arms.home[OTHER], (8, 1)))
    apart = np.abs(found[:, None, 6:] - branches[None]).max(axis=-1)
    assert (apart.min(axis=0) < 1e-6).all()
