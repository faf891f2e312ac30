"""Plans of a group of joints: only these move, whatever the goal; and a robot of which no group is known says so."""

import pickle

import numpy as np
import pytest

import two_arms
import ulna
from ulna.errors import InputError, UnknownNameError


@pytest.fixture(scope="module")
def robot():
    return ulna.load(two_arms.URDF, srdf=two_arms.SRDF)


@pytest.fixture(scope="module")
def start(robot):
    """Not at home, so that a joint that is not held would be seen."""
    q = robot.home + 0.05
    q[[2, 7]] = -0.6
    assert not robot.in_collision(q)
    return q


def columns(robot, group="left_arm"):
    return list(robot.groups[group].columns)


def only_moves(robot, plan, group="left_arm"):
    others = np.setdiff1d(np.arange(robot.n_dof), columns(robot, group))
    return bool(plan) and (plan.path[:, others] == plan.path[0, others]).all()


def left_goal(robot, start):
    q = start.copy()
    q[columns(robot)] = (0.6, -0.9, 1.2, 0.3, 0.4)
    return q


def test_only_the_joints_of_the_group_move_round_an_object(robot, start):
    goal, world = left_goal(robot, start), ulna.World()
    T = robot.forward_kinematics((start + goal) / 2, link="left_hand")
    world.add("pole", ulna.Box((0.05, 0.05, 0.4)), T)
    plan = robot.plan(start, goal, world, group="left_arm")
    assert only_moves(robot, plan)
    assert len(plan.path) > 2
    assert not robot.in_collision(plan.at(np.linspace(0, 1, 5001)), world).any()


def test_a_goal_may_have_the_joints_of_the_group_alone(robot, start):
    goal = left_goal(robot, start)
    whole, alone = robot.plan(start, goal, group="left_arm"), robot.plan(start, goal[columns(robot)], group="left_arm")
    assert np.array_equal(whole.path, alone.path)
    several = robot.plan(start, np.stack([goal, start])[:, columns(robot)], group="left_arm")
    assert only_moves(robot, several)
    with pytest.raises(InputError, match="goal: shape"):
        robot.plan(start, goal[columns(robot)])


def test_a_pose_is_of_the_tip_of_the_group_and_the_torso_stays(robot, start):
    T = robot.forward_kinematics(left_goal(robot, start), link="left_hand")
    plan = robot.plan(start, T, group="left_arm")
    assert only_moves(robot, plan)
    assert np.allclose(robot.forward_kinematics(plan.path[-1], link="left_hand"), T, atol=2e-5)
    with pytest.raises(InputError, match="link: the group 'both_arms' has the tips left_hand, right_hand"):
        robot.plan(start, T, group="both_arms")
    assert only_moves(robot, robot.plan(start, T, group="both_arms", link="left_hand"), "both_arms")


def test_a_joint_that_is_held_besides_does_not_move_either(robot, start):
    goal = left_goal(robot, start)
    goal[columns(robot)[0]] = start[columns(robot)[0]]
    plan = robot.plan(start, goal, group="left_arm", held=["left_joint1"])
    assert only_moves(robot, plan)
    assert (plan.path[:, columns(robot)[0]] == start[columns(robot)[0]]).all()


def test_a_goal_that_moves_a_joint_outside_the_group_is_refused(robot, start):
    said = r"goal: joint 'left_joint1' would move from 0\.05 to 0\.6, but it is held, or outside the group"
    with pytest.raises(InputError, match=said):
        robot.plan(start, left_goal(robot, start), group="right_arm")


def test_a_goal_of_a_wrong_shape_is_refused_with_the_joints_of_the_group(robot, start):
    names = ", ".join(robot.groups["left_arm"].joint_names)
    for goal in (np.zeros(4), np.empty((0, 5)), np.empty((0, 4, 4)), np.zeros((2, 2, 5))):
        with pytest.raises(InputError, match=rf"of the group 'left_arm', shape \(5,\) or \(n, 5\): {names}; or of all joints"):
            robot.plan(start, goal, group="left_arm")
    with pytest.raises(InputError, match=r"goal\[2\]: nan"):  # the third of the group, not of the robot
        robot.plan(start, [0, 0, np.nan, 0, 0], group="left_arm")


def test_a_pose_of_a_link_that_the_group_does_not_move_is_refused(robot, start):
    T = {link: robot.forward_kinematics(start, link=link) for link in ("left_hand", "right_hand")}
    with pytest.raises(InputError, match="link: no joint of the group 'left_arm' moves link 'right_hand'"):
        robot.plan(start, T["right_hand"], group="left_arm", link="right_hand")
    with pytest.raises(InputError, match="goal: no joint of the group 'left_arm' moves link 'right_hand' and no other link"):
        robot.plan(start, T, group="left_arm")


@pytest.mark.parametrize("options", [{"group": "left_arm"}, {"held": ["torso"]}, {}])
def test_a_start_beyond_the_limits_of_a_joint_that_stays_is_the_fault_of_the_start(robot, start, options):
    beyond, goal = start.copy(), left_goal(robot, start)
    beyond[0] = goal[0] = 4.0
    for wanted in [goal, goal[columns(robot)]] if "group" in options else [goal]:
        plan = robot.plan(beyond, wanted, **options)
        assert str(plan).startswith("start beyond limits: torso by 1")
    goal[columns(robot)[0]] = 3.5
    with pytest.raises(InputError, match=r"goal: 3\.5 of joint 'left_joint1' is outside its limits"):
        robot.plan(beyond, goal, **options)


def test_rows_of_plan_many_are_those_of_plan(robot, start):
    goals = np.stack([left_goal(robot, start), start])
    with ulna.threads(2):
        plans = robot.plan_many(start, goals[:, columns(robot)], group="left_arm")
    singles = [robot.plan(start, q, group="left_arm") for q in goals]
    assert all(np.array_equal(plan.path, single.path) for plan, single in zip(plans, singles, strict=True))
    assert np.array_equal(pickle.loads(pickle.dumps(plans[0])).path, plans[0].path)  # noqa: S301


def test_an_unknown_group_is_refused_with_those_there_are(robot, start):
    with pytest.raises(UnknownNameError, match="did you mean 'left_arm'") as refused:
        robot.plan(start, start, group="left_arms")
    assert set(refused.value.known) == set(robot.groups)
    with pytest.raises(InputError, match="group: JointGroup; the name of a group of the SRDF is expected"):
        robot.plan(start, start, group=robot.groups["left_arm"])
    with pytest.raises(InputError, match="group: 'hands' has no moving joints"):
        robot.plan(start, start, group="hands")


def test_a_robot_without_groups_says_where_they_come_from(panda):
    with pytest.raises(UnknownNameError, match=r"there are none; groups are read from an SRDF: ulna.load\(..., srdf=...\)"):
        panda.plan(panda.home, panda.home, group="panda_arm")
