"""The SRDF beside a URDF: where it is found, which one of several, and what is not taken."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import ulna
from robot_files import EXAMPLES
from ulna import DescriptionWarning, InputError

BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
URDF = f"""<robot name="arm"><link name="base">{BALL}</link><link name="upper"/><link name="hand">{BALL}</link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="hand"/><origin xyz="1 0 0"/></joint>
</robot>"""
SRDF = """<robot name="arm"><group name="all"><chain base_link="base" tip_link="hand"/></group>
  <disable_collisions link1="base" link2="hand" reason="Never"/></robot>"""
XACRO = SRDF.replace('name="arm"', """name="${'a' + 'rm'}" xmlns:xacro="http://www.ros.org/wiki/xacro" """, 1)


@pytest.fixture
def urdf(tmp_path):
    """A URDF in ``urdf`` of a package in a workspace."""
    return write(tmp_path / "src" / "kind_description" / "urdf" / "model.urdf", URDF)


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ("kind_description/urdf/arm.srdf", SRDF),
        ("kind_description/srdf/model.srdf", SRDF),
        ("kind_description/srdf/other.srdf", SRDF),
        ("arm_moveit_config/config/arm.srdf", SRDF),
        ("model_moveit_config/config/arm.srdf", SRDF),
        ("kind_moveit_config/config/arm.srdf.xacro", XACRO),
    ],
)
def test_it_is_found_and_refused_with_false(urdf, tmp_path, place, text):
    path = write(tmp_path / "src" / place, text)
    robot = ulna.load(urdf)
    assert Path(robot.srdf.found_at).samefile(path)
    assert list(robot.groups) == ["all"]
    assert ("base", "hand") in robot.allowed_collisions
    refused = ulna.load(urdf, srdf=False)
    assert (refused.srdf.found_at, list(refused.groups), ("base", "hand") in refused.allowed_collisions) == ("", [], False)
    assert ulna.load(urdf, srdf=path).srdf.found_at == ""
    assert ulna.load(URDF).srdf.found_at == ""  # text has no folder


def test_a_config_package_is_found_in_package_dirs_and_on_the_path_of_ros(urdf, tmp_path, monkeypatch):
    path = write(tmp_path / "elsewhere" / "arm_moveit_config" / "config" / "arm.srdf", SRDF)
    assert ulna.load(urdf).srdf.found_at == ""
    assert ulna.load(urdf, package_dirs=[tmp_path / "elsewhere"]).srdf.found_at == str(path)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere"))
    assert ulna.load(urdf).srdf.found_at == str(path)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('name="arm"', 'name="leg"', "it is of the robot 'leg', not of 'arm'"),
        ('link2="hand"', 'link2="foot"', "it names links that the robot lacks: foot"),
        ('tip_link="hand"', 'tip_link="toe"', "it names links that the robot lacks: toe"),
        ("</robot>", "", "not XML"),
        ("</group>", '</group><group name="all"/>', "<group> 'all' is defined twice"),
        (
            "</robot>",
            '<group_state name="s" group="all"><joint name="elbow" value="1 2"/></group_state></robot>',
            "1 number expected",
        ),
    ],
)
def test_one_that_does_not_fit_is_passed_over_and_inspect_says_why(urdf, old, new, reason):
    assert old in SRDF
    path = write(urdf.parents[1] / "srdf" / "model.srdf", SRDF.replace(old, new, 1))
    robot = ulna.load(urdf)
    assert not robot.groups
    (sentence,) = robot.srdf.passed_over
    assert sentence.startswith(f"{path} lies beside the URDF and is not used: ")
    assert reason in sentence
    assert sentence in [finding.message for finding in ulna.inspect(urdf).findings]


def test_of_several_the_one_called_like_the_urdf_is_taken_then_the_one_called_like_the_robot(urdf):
    folder = urdf.parents[1] / "srdf"
    write(folder / "a.srdf", SRDF)
    arm = write(folder / "arm.srdf", SRDF)
    assert ulna.load(urdf).srdf.found_at == str(arm)
    model = write(folder / "model.srdf", SRDF)
    assert ulna.load(urdf).srdf.found_at == str(model)


def test_of_several_of_other_names_none_is_taken_and_all_are_named(urdf):
    paths = [write(urdf.parents[1] / "srdf" / name, SRDF) for name in ("a.srdf", "b.srdf")]
    sentence = f"2 SRDFs beside model.urdf fit it ({paths[0]}, {paths[1]}); none is used"
    with pytest.warns(DescriptionWarning) as caught:
        assert not ulna.load(urdf).groups
    assert str(caught[0].message).startswith(sentence)
    assert caught[0].filename == __file__  # whoever called is warned
    assert any(finding.message.startswith(sentence) for finding in ulna.inspect(urdf).findings)
    assert not ulna.load(urdf, srdf=False).groups


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a pipe")
def test_what_is_not_a_file_and_names_that_lead_away_do_no_harm(urdf, tmp_path):
    (urdf.parents[1] / "srdf").mkdir()
    os.mkfifo(urdf.parents[1] / "srdf" / "model.srdf")
    loop = urdf.parent / "arm.srdf"
    loop.symlink_to(loop)
    write(tmp_path / "away_moveit_config" / "config" / "away.srdf", SRDF.replace('"arm"', '"../../away"'))
    urdf.write_text(URDF.replace('"arm"', '"../../away"', 1))
    assert ulna.load(urdf).srdf.found_at == ""
    assert "not a regular file" in " ".join(ulna.load(urdf).srdf.passed_over)


@pytest.mark.parametrize("srdf", [True, 1])
def test_only_false_refuses(urdf, srdf):
    with pytest.raises(InputError, match=r"^srdf: "):
        ulna.load(urdf, srdf=srdf)


@pytest.mark.parametrize(
    ("robot", "file"),
    [("ur5", "ur5"), ("ur5_gripper", "ur5_gripper"), ("talos", "talos"), ("baxter", "baxter_manipulation"), ("ur3", "")],
)
def test_those_of_example_robot_data(robot, file):
    found = ulna.load(robot).srdf.found_at
    assert (found.removeprefix(str(EXAMPLES)).rpartition("/")[2]) == (f"{file}.srdf" if file else "")


@pytest.mark.slow
def test_a_ur5_of_hulls_plans_between_random_free_configurations():
    robot = ulna.load("ur5", meshes="hulls")
    q = robot.random(100, seed=1)
    q = q[~robot.in_collision(q)]
    assert all(robot.plan(q[2 * i], q[2 * i + 1]) for i in range(10))
    without = ulna.load("ur5", meshes="hulls", srdf=False)
    assert np.count_nonzero(without.in_collision(q)) > len(q) // 5


@pytest.mark.slow
def test_inspect_says_which_hulls_touch_how_often_and_what_to_do(tmp_path):
    messages = [finding.message for finding in ulna.inspect("ur5").findings]
    assert any(
        message.endswith("ur5.srdf lies beside the URDF and is used; 10 pairs of links may touch by it") for message in messages
    )
    assert not any(message.startswith("hulls touch") for message in messages)
    alone = shutil.copy(EXAMPLES / "ur_description" / "urdf" / "ur5_robot.urdf", tmp_path)
    (said,) = (finding for finding in ulna.inspect(alone).findings if finding.message.startswith("hulls touch"))
    assert said.severity == "note"
    assert (
        "of 2000 random q: base_link and upper_arm_link at 671 (34%), forearm_link and wrist_2_link at 508 (25%)" in said.message
    )
    assert "robot.with_allowed_collisions(at=q)" in said.message
    baxter = ulna.inspect("baxter").findings
    assert not any(finding.message.startswith("hulls touch at robot.home") for finding in baxter)
    tiago = [finding for finding in ulna.inspect("tiago").findings if finding.message.startswith("hulls touch")]
    assert [finding.severity for finding in tiago] == ["warning", "note"]
    assert "hulls touch at robot.home: arm_1_link and torso_fixed_column_link" in tiago[1].message
