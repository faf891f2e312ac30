"""``ulna plan --goal``: poses of several links, to which they come together."""

import json

import numpy as np
import pytest

import two_arms
import ulna
from ulna.description.pose import rpy_from_matrix

HANDS = "left_hand", "right_hand"


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "arms.urdf").write_text(two_arms.URDF, encoding="utf-8")
    (tmp_path / "arms.srdf").write_text(two_arms.SRDF, encoding="utf-8")
    return ulna.load(tmp_path / "arms.urdf", srdf=tmp_path / "arms.srdf")


@pytest.fixture
def options(robot, tmp_path):
    return ["plan", str(tmp_path / "arms.urdf"), "--srdf", str(tmp_path / "arms.srdf")]


def numbers(values):
    return ",".join(map(str, values))


@pytest.mark.parametrize("more", [[], ["--group", "both_arms"]])
@pytest.mark.parametrize("degrees", [False, True])
def test_both_hands_come_to_their_poses_together(run, robot, options, degrees, more):
    q = robot.home.copy()
    q[1:6], q[6:] = (0.6, -0.9, 1.2, 0.3, 0.4), (-0.3, -0.5, 0.7, 0.2, 0.1)
    poses, asked = {hand: robot.forward_kinematics(q, link=hand) for hand in HANDS}, []
    for hand, T in poses.items():
        turn = rpy_from_matrix(T)
        asked += ["--goal", f"{hand}={numbers([*T[:3, 3], *(np.degrees(turn) if degrees else turn)])}"]
    found = json.loads(run(*options, *asked, *more, *["--degrees"] * degrees, "--json").stdout)
    assert found["success"], found["reason"]
    assert found["certified"]
    end = np.array(found["path"][-1])
    for hand, T in poses.items():
        assert np.allclose(robot.forward_kinematics(end, link=hand), T, atol=2e-5)


def test_three_numbers_are_a_position_and_the_hand_stays_turned_as_at_home(run, robot, options):
    asked = []
    for hand in HANDS:
        asked += ["--goal", f"{hand}={numbers(robot.forward_kinematics(robot.home, link=hand)[:3, 3])}"]
    found = json.loads(run(*options, *asked, "--json").stdout)
    assert found["success"], found["reason"]
    assert np.allclose(found["path"][0], robot.home)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--goal", "0.4,0,0.4"], "--goal: '0.4,0,0.4'; LINK=x,y,z or LINK=x,y,z,roll,pitch,yaw is expected"),
        (["--goal", "left_hand=1,2"], "--goal: 2 numbers, but 6 are expected: x, y, z, roll, pitch, yaw"),
        (["--goal", "left_hnd=1,2,3"], "no link is called 'left_hnd'; did you mean 'left_hand'?"),
        (["--goal", "left_hnd=1,2,3,0,0,0"], "no link is called 'left_hnd'; did you mean 'left_hand'?"),
        (["--goal", "left_hand=1,2,3", "--goal", "left_hand=1,2,3"], "--goal: the link 'left_hand' is named twice"),
        (["--goal", "left_hand=1,2,3", "--to", "up"], "--to, --xyz, --pose, --goal: one of them is expected"),
        (["--goal", "left_hand=1,2,3", "--link", "left_hand"], "--frame: require --xyz or --pose; --goal names its links"),
        (
            ["--goal", "right_hand=1,2,3", "--group", "left_arm"],
            "--goal: no joint of the group 'left_arm' moves link 'right_hand'",
        ),
        (["--goal", "left_5=1,2,3", "--goal", "left_hand=1,2,3"], "--goal: no joint moves link 'left_5' that does not move"),
    ],
)
def test_what_cannot_be_a_goal_is_refused_by_name(run, options, more, said):
    refused = run(*options, *more)
    assert refused.exit_code == 2
    assert said in " ".join(refused.output.split())
