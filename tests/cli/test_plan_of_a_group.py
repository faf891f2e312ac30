"""``ulna plan --group``: the joints of one group of an SRDF, and its states as goals."""

import json
from pathlib import Path

import numpy as np
import pytest

import two_arms
import ulna

UP = "left_arm/up"


@pytest.fixture
def arms(tmp_path):
    """The options that load the robot, and the robot."""
    for name, text in (("arms.urdf", two_arms.URDF), ("arms.srdf", two_arms.SRDF)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    paths = [str(tmp_path / name) for name in ("arms.urdf", "arms.srdf")]
    return [paths[0], "--srdf", paths[1]], ulna.load(paths[0], srdf=paths[1])


@pytest.mark.parametrize("more", [["--to", UP], ["--to", UP, "--group", "left_arm"], ["--to", "up", "--group", "left_arm"]])
def test_a_state_of_the_srdf_is_a_goal_and_joints_that_it_does_not_name_stay(run, arms, more):
    options, robot = arms
    start = robot.home + 0.1
    begin = ",".join(map(str, start))
    found = json.loads(run("plan", *options, "--from", begin, *more, "--json").stdout)
    assert found["success"], found["reason"]
    end, state = found["path"][-1], robot.named_configurations[UP]
    named = [name in {"left_joint2", "left_joint3"} for name in robot.joint_names]
    assert np.allclose(end, np.where(named, state, start))


@pytest.mark.parametrize("name", ["pi", "pick", "1", "0.3,-0.5,0.7,0.1,0.2"])
def test_the_name_of_a_state_counts_before_a_number(run, arms, name):
    options, robot = arms
    srdf = two_arms.SRDF.replace('name="up"', f'name="{name}"')
    Path(options[2]).write_text(srdf, encoding="utf-8")
    found = json.loads(run("plan", *options, "--to", name, "--group", "left_arm", "--json").stdout)
    assert found["success"], found["reason"]
    assert np.allclose(found["path"][-1], robot.named_configurations[UP])
    back = json.loads(run("plan", *options, "--from", f"left_arm/{name}", "--to", ",".join("0" * 11), "--json").stdout)
    assert np.allclose(back["path"][0], robot.named_configurations[UP])


def test_numbers_are_those_of_the_group_and_a_position_is_that_of_its_tip(run, arms):
    options, robot = arms
    q = robot.home.copy()
    q[list(robot.groups["left_arm"].columns)] = 0.3, -0.5, 0.7, 0.1, 0.2
    found = json.loads(run("plan", *options, "--group", "left_arm", "--to", "0.3,-0.5,0.7,0.1,0.2", "--json").stdout)
    assert np.allclose(found["path"][-1], q)
    refused = run("plan", *options, "--group", "left_arm", "--to", "1,2")
    assert refused.exit_code == 2
    assert "5 are expected: left_joint1" in refused.output
    home = json.loads(run("plan", *options, "--group", "left_arm", "--from", "left_arm/up", "--to", "home", "--json").stdout)
    assert np.allclose(home["path"][-1], robot.home)
    x, y, z = robot.forward_kinematics(robot.home, link="left_hand")[:3, 3]
    reached = json.loads(run("plan", *options, "--group", "left_arm", "--xyz", f"{x},{y},{z}", "--json").stdout)
    assert reached["success"], reached["reason"]


def test_a_position_is_of_the_named_tip_where_a_group_has_several(run, arms):
    options, robot = arms
    to_reach = [
        "--group",
        "both_arms",
        "--xyz",
        ",".join(map(str, robot.forward_kinematics(robot.home, link="right_hand")[:3, 3])),
    ]
    refused = run("plan", *options, *to_reach, "--json")
    assert refused.exit_code == 2
    said = "--link: the group 'both_arms' has the tips left_hand, right_hand; name the link that the pose is of"
    assert said in " ".join(refused.output.split())
    found = json.loads(run("plan", *options, *to_reach, "--link", "right_hand", "--json").stdout)
    assert found["success"], found["reason"]
    assert np.allclose(found["path"], robot.home)


def test_an_unknown_group_or_state_is_refused_with_those_there_are(run, arms):
    options, _ = arms
    for more, said in (
        (["--group", "left", "--to", "up"], "no group is called 'left'; did you mean 'left_arm'?"),
        (["--to", "down"], "no state of the SRDF is called 'down'; the only one is 'left_arm/up'"),
        (["--to", "pinch"], "no state of the SRDF is called 'pinch'; the only one is 'left_arm/up'"),  # not a number with pi
        (["--from", "pick", "--to", "up"], "no state of the SRDF is called 'pick'"),
        (["--to", "pi"], "--to: 1 number, but 11 are expected"),
        (["--to", "nan,0,0,0,0", "--group", "left_arm"], "--to: 'nan' is not a number"),
        (["--to", "left_arm/up", "--group", "right_arm"], "--to: joint 'left_joint2' would move from 0 to -1.2, but it is held"),
    ):
        refused = run("plan", *options, *more)
        assert refused.exit_code == 2
        assert said in " ".join(refused.output.split())


def test_a_held_joint_keeps_its_position_and_the_json_names_joints_that_had_to_move(run, arms):
    options, robot = arms
    T = robot.forward_kinematics(robot.home + 0.2 * np.isin(robot.joint_names, ["left_joint2", "left_joint3"]), link="left_hand")
    goal = "left_hand=" + ",".join(map(str, (*T[:3, 3], 0, np.arctan2(-T[2, 0], T[0, 0]), 0)))
    found = json.loads(run("plan", *options, "--goal", goal, "--held", "left_joint1", "--held", "left_joint4", "--json").stdout)
    assert found["success"], found["reason"]
    stays = ~np.isin(robot.joint_names, ["left_joint2", "left_joint3", "left_joint5"])
    assert (np.array(found["path"])[:, stays] == robot.home[stays]).all()
    assert found["moved"] == []
    for joint, said in (
        ("left_joint2", "--to: joint 'left_joint2' would move from 0 to -1.2"),
        ("left", "no joint is called 'left'"),
    ):
        refused = run("plan", *options, "--to", UP, "--held", joint)
        assert refused.exit_code == 2
        assert said in " ".join(refused.output.split())
