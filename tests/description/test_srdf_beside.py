"""The SRDF beside a URDF: where it is found, which one of several, and what is not taken."""

import os
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import ulna
from robot_files import EXAMPLES
from ulna import DescriptionError, DescriptionWarning, InputError
from ulna.description import srdf_beside

BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
URDF = f"""<robot name="arm"><link name="base">{BALL}</link><link name="upper"/><link name="hand">{BALL}</link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="hand"/><origin xyz="1 0 0"/></joint>
</robot>"""
SRDF = """<robot name="arm"><group name="all"><chain base_link="base" tip_link="hand"/></group>
  <disable_collisions link1="base" link2="hand" reason="Never"/></robot>"""
XACRO = SRDF.replace('name="arm"', """name="${'a' + 'rm'}" xmlns:xacro="http://www.ros.org/wiki/xacro" """, 1)


MANIFEST = "<package><name>{}</name>{}</package>"


@pytest.fixture
def urdf(tmp_path):
    """A URDF in ``urdf`` of a package in a workspace, beside three packages of MoveIt, which are empty."""
    write(tmp_path / "src" / "kind_description" / "package.xml", MANIFEST.format("kind_description", ""))
    for name in ("arm", "model", "kind"):
        write_manifest(tmp_path / "src" / f"{name}_moveit_config")
    return write(tmp_path / "src" / "kind_description" / "urdf" / "model.urdf", URDF)


def write_manifest(config, depends="<run_depend>kind_description</run_depend>"):
    return write(config / "package.xml", MANIFEST.format(config.name, depends))


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
    write_manifest(path.parents[1], "<exec_depend>kind_description</exec_depend>")
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
    with pytest.warns(DescriptionWarning) as caught:
        robot = ulna.load(urdf)
    assert not robot.groups
    (sentence,) = robot.srdf.passed_over
    assert [str(one.message) for one in caught] == [sentence]
    assert caught[0].filename == __file__
    assert sentence.startswith(f"{path} is next to the URDF and is not used: ")
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
    sentence = f"2 SRDFs next to model.urdf match it ({paths[0]}, {paths[1]}); none is used"
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
    with pytest.warns(DescriptionWarning):
        robot = ulna.load(urdf)
    assert robot.srdf.found_at == ""
    assert "not a regular file" in " ".join(robot.srdf.passed_over)


def passed_over(urdf):
    """What ``load`` says that it does not use, of a robot that then may not touch itself."""
    with pytest.warns(DescriptionWarning) as caught:
        robot = ulna.load(urdf)
    assert (robot.srdf.found_at, ("base", "hand") in robot.allowed_collisions) == ("", False)
    assert [str(one.message) for one in caught] == list(robot.srdf.passed_over)
    return " ".join(robot.srdf.passed_over)


@pytest.mark.parametrize("above", range(6))
def test_a_planted_config_package_without_its_package_xml_is_not_used(tmp_path, above):
    urdf = write(tmp_path.joinpath(*"abcdefg") / "model.urdf", URDF)
    planted = urdf.parents[above] / "arm_moveit_config"
    write(planted / "config" / "arm.srdf", SRDF)
    assert f"{planted} has no package.xml that names it arm_moveit_config, so no SRDF in it is used" in passed_over(urdf)


@pytest.mark.parametrize("depends", ["", "<depend>other</depend>", "<test_depend>kind_description</test_depend>"])
def test_a_config_package_that_does_not_depend_on_the_package_of_the_urdf_is_not_used(urdf, tmp_path, depends):
    config = tmp_path / "src" / "arm_moveit_config"
    write_manifest(config, depends)
    write(config / "config" / "arm.srdf", SRDF)
    assert "does not depend on kind_description, the package of model.urdf" in passed_over(urdf)


def test_a_urdf_outside_any_package_takes_an_srdf_from_its_own_folder_only(urdf, tmp_path):
    (urdf.parents[1] / "package.xml").unlink()
    write(urdf.parents[1] / "srdf" / "arm.srdf", SRDF)
    write(tmp_path / "src" / "arm_moveit_config" / "config" / "arm.srdf", SRDF)
    assert "cannot depend on the package of model.urdf, which is in none" in passed_over(urdf)
    own = write(urdf.parent / "arm.srdf", SRDF)
    with pytest.warns(DescriptionWarning, match="is in none"):
        assert ulna.load(urdf).srdf.found_at == str(own)


def test_a_folder_beside_the_package_itself_is_not_in_it(urdf):
    write(urdf.parents[2] / "srdf" / "model.srdf", SRDF)
    top = write(urdf.parents[1] / "model.urdf", URDF)
    assert ulna.load(top).srdf.found_at == ""


@pytest.mark.parametrize("place", ["kind_description/urdf", "kind_description/srdf", "arm_moveit_config/config"])
@pytest.mark.parametrize("of", ["file", "folder"])
def test_a_link_that_leads_out_is_not_followed_and_its_text_is_not_shown(urdf, tmp_path, place, of):
    outside = write(tmp_path / "private" / "arm.srdf", SRDF.replace("Never", "SECRET")).parent
    folder = tmp_path / "src" / place
    if of == "file":
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "arm.srdf").symlink_to(outside / "arm.srdf")
    elif folder != urdf.parent:
        folder.symlink_to(outside)
    else:
        return  # the folder of the URDF is whatever its user calls so
    said = passed_over(urdf)
    assert "is a link to a file outside the URDF's folder and package, so it is not used" in said
    assert "SECRET" not in said


def test_a_link_within_the_package_is_followed(urdf):
    path = write(urdf.parents[1] / "srdf" / "other.srdf", SRDF)
    (urdf.parent / "arm.srdf").symlink_to(path)
    assert ulna.load(urdf).srdf.found_at == str(urdf.parent / "arm.srdf")


def test_few_files_are_looked_at_and_expanded_for_a_few_seconds_in_sum(urdf, monkeypatch):
    for k in range(30):
        write(urdf.parent / f"arm{k}.srdf.xacro", XACRO)
    now, asked = [0.0], []

    def expanded_slowly(document, arguments, max_seconds):
        asked.append((document.file, arguments, max_seconds))
        now[0] += max_seconds
        raise DescriptionError("xacro: not finished within 5 s; expansion stopped", document.source)

    monkeypatch.setattr(srdf_beside, "expanded", expanded_slowly)
    monkeypatch.setattr(srdf_beside, "time", SimpleNamespace(monotonic=lambda: now[0]))
    said = passed_over(urdf)
    assert "30 SRDFs are next to model.urdf; only 20 of them are read" in said
    assert "17 more files next to model.urdf are not read, after 10 s" in said
    assert [seconds for _, _, seconds in asked] == [5.0] * 3


def test_one_that_may_be_one_of_several_is_not_taken(urdf):
    for k in range(21):
        write(urdf.parent / f"a{k}.srdf", SRDF if k == 0 else SRDF.replace('"arm"', '"leg"', 1))
    with pytest.warns(DescriptionWarning) as caught:
        assert ulna.load(urdf).srdf.found_at == ""
    assert any("1 SRDF next to model.urdf matches it" in str(one.message) for one in caught)


def test_a_document_that_computes_without_end_is_stopped_after_five_seconds(urdf, monkeypatch):
    monkeypatch.setattr(srdf_beside, "_MAX_SECONDS_EACH", 1.0)
    endless = "${[a for a in range(100000000) if a in range(10) and len(str(a)) == 3]}"
    write(urdf.parent / "arm.srdf.xacro", XACRO.replace("</robot>", f'<passive_joint name="{endless}"/></robot>'))
    assert "xacro: not finished within 1 s; expansion stopped" in passed_over(urdf)


def test_what_is_taken_is_logged(urdf, caplog):
    path = write(urdf.parent / "arm.srdf", SRDF)
    with caplog.at_level("INFO", logger="ulna"):
        ulna.load(urdf)
    assert f"{path} is next to model.urdf and is used; it allows contacts of 1 pair of links" in caplog.text


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
        message.endswith("ur5.srdf is next to the URDF and is used; it allows contacts of 10 pairs of links")
        for message in messages
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
