"""Plans from and to named states of a semantic description: by their key, by their name in a group, or by the only such name."""

import numpy as np
import pytest

import two_arms
import ulna
from ulna.errors import InputError, UnknownNameError

MORE = """<group_state name="pinch" group="right_arm"><joint name="right_joint2" value="-0.7"/></group_state>
<group_state name="apart" group="left_arm"><joint name="left_joint1" value="0.5"/></group_state>
<group_state name="apart" group="right_arm"><joint name="right_joint1" value="-0.5"/></group_state></robot>"""


@pytest.fixture(scope="module")
def robot():
    return ulna.load(two_arms.URDF, srdf=two_arms.SRDF.replace("</robot>", MORE))


@pytest.mark.parametrize(
    ("name", "group", "key"),
    [
        ("left_arm/up", None, "left_arm/up"),
        ("left_arm/up", "left_arm", "left_arm/up"),
        ("up", "left_arm", "left_arm/up"),
        ("pinch", None, "right_arm/pinch"),  # the only one of that name
        ("apart", "right_arm", "right_arm/apart"),
        ("left_arm/up", "both_arms", "left_arm/up"),
    ],
)
def test_a_state_is_a_goal_and_joints_that_it_does_not_name_stay(robot, name, group, key):
    start = robot.home + 0.1
    end = robot.plan(start, name, group=group).path[-1]
    (state,) = (state for state in robot.srdf.states if state.key == key)
    values = {joint: values[0] for joint, values in state.values}
    assert np.array_equal(end, [values.get(joint, q) for joint, q in zip(robot.joint_names, start, strict=True)])


def test_a_state_is_a_start_and_other_joints_are_at_home(robot):
    plan = robot.plan("up", "apart", group="left_arm")
    assert plan
    assert np.array_equal(plan.path[0], robot.named_configurations["left_arm/up"])


def test_a_name_that_is_not_that_of_one_state_is_refused_with_those_there_are(robot, panda):
    start = robot.home
    for name, group, known in (
        ("apart", None, {"left_arm/apart", "right_arm/apart"}),
        ("up", "right_arm", {"left_arm/up"}),
        ("down", "left_arm", set(robot.named_configurations)),
    ):
        with pytest.raises(UnknownNameError, match=f"no state of the SRDF is called '{name}'") as refused:
            robot.plan(start, name, group=group)
        assert set(refused.value.known) == known
    with pytest.raises(UnknownNameError, match=r"there are none; states are read from an SRDF"):
        panda.plan("ready", panda.home)
    with pytest.raises(InputError, match=r"goal: joint 'left_joint2' would move from 0 to -1\.2, but it is held"):
        robot.plan(start, "left_arm/up", group="right_arm")


def test_many_plans_go_between_states(robot):
    starts = np.stack([robot.home, robot.home + 0.1])
    named = robot.plan_many(["left_arm/up", "pinch"], ["pinch", "left_arm/up"])
    for plan, (start, goal) in zip(named, (("left_arm/up", "pinch"), ("pinch", "left_arm/up")), strict=True):
        assert np.array_equal(plan.path, robot.plan(start, goal).path)
    for plan, start in zip(robot.plan_many(starts, "pinch"), starts, strict=True):
        assert np.array_equal(plan.path, robot.plan(start, "pinch").path)
    for plan, end in zip(robot.plan_many("pinch", starts), starts, strict=True):
        assert np.array_equal(plan.path, robot.plan("pinch", end).path)
    with pytest.raises(InputError, match="2 goals, 3 starts and 1 world do not go together"):
        robot.plan_many(["pinch"] * 3, ["pinch", "left_arm/up"])
    with pytest.raises(UnknownNameError, match="pinched"):
        robot.plan_many(["pinch", "pinched"], starts)
    (one,) = robot.plan_many(np.array(["up"]), "apart", group="left_arm")
    assert np.array_equal(one.path, robot.plan("up", "apart", group="left_arm").path)
