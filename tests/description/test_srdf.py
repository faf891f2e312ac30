"""SRDF: how each element is read, what is refused, and what is ignored with a warning."""

import re
from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError, DescriptionWarning, FileError, InputError
from ulna.description.document import Document
from ulna.description.semantic import DisabledCollision, EndEffector, Group, GroupState, Srdf, VirtualJoint
from ulna.description.srdf import read_srdf

ARM = """<robot name="arm">
  <link name="base"/><link name="upper"/><link name="hand"/><link name="finger"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="hand"/></joint>
  <joint name="weld" type="fixed"><parent link="hand"/><child link="finger"/></joint>
</robot>"""
SRDF = """<robot name="arm">
  <virtual_joint name="world" type="floating" parent_frame="map" child_link="base"/>
  <passive_joint name="elbow"/>
  <group name="arm"><chain base_link="base" tip_link="hand"/></group>
  <group name="tool"><joint name="weld"/><link name="finger"/></group>
  <group name="all"><group name="arm"/><group name="tool"/></group>
  <end_effector name="grip" parent_link="hand" group="tool" parent_group="arm"/>
  <group_state name="up" group="arm"><joint name="shoulder" value="1.5"/></group_state>
  <group_state name="away"><joint name="elbow" value="-1e-1"/><joint name="world" value="0 0 0 0 0 0 1"/></group_state>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="base" link2="hand"/>
  <gripper name="other programs' business"><link name="hand"/></gripper>
</robot>"""
READ = Srdf(
    name="arm",
    groups=(
        Group("arm", chains=(("base", "hand"),), line=4),
        Group("tool", links=("finger",), joints=("weld",), line=5),
        Group("all", subgroups=("arm", "tool"), line=6),
    ),
    end_effectors=(EndEffector("grip", "hand", "tool", "arm", 7),),
    states=(
        GroupState("up", "arm", (("shoulder", (1.5,)),), 8),
        GroupState("away", None, (("elbow", (-0.1,)), ("world", (0, 0, 0, 0, 0, 0, 1))), 9),
    ),
    disabled_collisions=(DisabledCollision("base", "upper", "Adjacent", 10), DisabledCollision("base", "hand", "", 11)),
    virtual_joints=(VirtualJoint("world", "floating", "map", "base", 2),),
    passive_joints=("elbow",),
    source="arm.srdf",
)


def changed(old: str, new: str, text: str = SRDF) -> str:
    assert old in text
    return text.replace(old, new, 1)


def test_every_element_is_read():
    assert read_srdf(Document(SRDF.encode(), "arm.srdf")) == READ


def test_a_robot_has_the_srdf_and_virtual_joints_are_not_in_q(tmp_path):
    (tmp_path / "arm.srdf").write_text(SRDF)
    robot = ulna.load(ARM, srdf=tmp_path / "arm.srdf")
    assert robot.srdf.groups == READ.groups
    assert robot.srdf.disabled_collisions == READ.disabled_collisions
    assert robot.srdf.warnings == ()
    assert [state.values for state in robot.srdf.states] == [(("shoulder", (1.5,)),), (("elbow", (-0.1,)),)]
    assert robot.end_effectors["grip"].parent_link == "hand"


def test_a_robot_without_an_srdf_has_an_empty_one():
    robot = ulna.load(ARM)
    assert robot.srdf == Srdf()
    assert (robot.groups, robot.end_effectors, robot.named_configurations) == ({}, {}, {})


# fmt: off
REFUSED = {
    "a URDF": (2, "defines a link: this is a URDF, where an SRDF is expected", SRDF, ARM),
    "another document": (1, "the root element is <sdf>, not <robot>: this is not an SRDF", SRDF, "<sdf/>"),
    "a group without a name": (4, "<group> has no attribute 'name'", ' name="arm"><chain', "><chain"),
    "two groups of one name": (5, "<group> 'arm' is defined twice, first in line 4", '<group name="tool"', '<group name="arm"'),
    "two states of one name": (9, "<group_state> 'arm/up' is defined twice, first in line 8",
        '<group_state name="away"', '<group_state name="up" group="arm"'),
    "two values of one joint": (9, "joint 'elbow' is given two values in one <group_state>",
        'name="world" value', 'name="elbow" value'),
    "a chain without an end": (4, "<chain> has no attribute 'tip_link'", ' tip_link="hand"', ""),
    "an end effector on no link": (7, "<end_effector> has no attribute 'parent_link'", ' parent_link="hand"', ""),
    "a pair of one": (11, "<disable_collisions> has no attribute 'link2'", ' link2="hand"', ""),
    "a state of no joint": (8, "<joint> has no attribute 'name'", '<joint name="shoulder"', "<joint"),
    "a value that is none": (8, "<joint> has no attribute 'value'", ' value="1.5"', ""),
    "a value in words": (8, "<joint> value='half': not numbers", '"1.5"', '"half"'),
    "a value that is infinite": (8, "<joint> value='inf': finite numbers expected", '"1.5"', '"inf"'),
    "two values for one": (8, "group state 'arm/up': joint 'shoulder' is continuous: 1 number expected, not 1 2",
        '"1.5"', '"1 2"'),
}
UNKNOWN = {
    "a joint of a group": (5, "group 'tool': joint 'wedl' is not defined; did you mean 'weld'?",
        'joint name="weld"', 'joint name="wedl"'),
    "a link of a group": (5, "group 'tool': link 'thumb' is not defined; there are 'base', 'upper', 'hand' and 1 more",
        'link name="finger"', 'link name="thumb"'),
    "an end of a chain": (4, "group 'arm': link 'bse' is not defined; did you mean 'base'?",
        'base_link="base"', 'base_link="bse"'),
    "a group of a group": (6, "group 'all': group 'armm' is not defined; did you mean 'arm'?",
        '<group name="arm"/>', '<group name="armm"/>'),
    "the link of an end effector": (7, "end effector 'grip': link 'hnd' is not defined; did you mean 'hand'?",
        'parent_link="hand"', 'parent_link="hnd"'),
    "the group of an end effector": (7, "end effector 'grip': group 'tol' is not defined; did you mean 'tool'?",
        'group="tool"', 'group="tol"'),
    "the group of a state": (8, "group state 'arn/up': group 'arn' is not defined; did you mean 'arm'?",
        'name="up" group="arm"', 'name="up" group="arn"'),
    "the joint of a state": (8, "group state 'arm/up': joint 'sholder' is not defined; did you mean 'shoulder'?",
        '"shoulder"', '"sholder"'),
    "a fixed joint in a state": (9, "group state 'away': joint 'weld' is fixed and takes no value",
        '<joint name="elbow"', '<joint name="weld"'),
    "a link of a pair": (11, "disabled collision: link 'hnad' is not defined; did you mean 'hand'?",
        'link2="hand"', 'link2="hnad"'),
    "the link of a virtual joint": (2, "virtual joint 'world': link 'bose' is not defined; did you mean 'base'?",
        'child_link="base"',
        'child_link="bose"'),
    "a passive joint": (None, "a passive joint: joint 'elbov' is not defined; did you mean 'elbow'?",
        '<passive_joint name="elbow"',
        '<passive_joint name="elbov"'),
}
# fmt: on


@pytest.mark.parametrize("name", REFUSED)
def test_an_invalid_element_is_refused_with_its_line(tmp_path, name):
    line, message, old, new = REFUSED[name]
    (tmp_path / "arm.srdf").write_text(changed(old, new))
    with pytest.raises(DescriptionError) as caught:
        ulna.load(ARM, srdf=tmp_path / "arm.srdf")
    assert (caught.value.source, caught.value.line, caught.value.message) == ("arm.srdf", line, message)


@pytest.mark.parametrize("name", UNKNOWN)
def test_an_unknown_name_is_ignored_with_one_warning(tmp_path, name):
    line, message, old, new = UNKNOWN[name]
    (tmp_path / "arm.srdf").write_text(changed(old, new))
    expected = f"arm.srdf: {message}" if line is None else f"arm.srdf:{line}: {message}"
    with pytest.warns(DescriptionWarning, match=f"^{re.escape(expected)}$") as caught:
        robot = ulna.load(ARM, srdf=tmp_path / "arm.srdf")
    assert robot.srdf.warnings == (expected,)
    assert Path(caught[0].filename) == Path(__file__)  # whoever called is warned
    wrong = re.search(r"(\w+) '(\w+)' is", message)[2]
    kept = repr((robot.srdf.groups, robot.srdf.disabled_collisions, robot.srdf.virtual_joints, robot.srdf.passive_joints))
    assert f"'{wrong}'" not in kept or wrong == "weld"


def test_several_warnings_are_given_as_one_with_their_count():
    text = changed('joint name="weld"', 'joint name="a"/><joint name="b"')
    with pytest.warns(DescriptionWarning, match=r"joint 'a' .* \(2 such sentences: robot.srdf.warnings\)$") as caught:
        robot = ulna.load(ARM, srdf=text)
    assert (len(caught), len(robot.srdf.warnings)) == (1, 2)


def test_disable_default_collisions_disables_all_pairs_but_those_enabled():
    more = '<disable_default_collisions link="hand"/><enable_collisions link1="upper" link2="hand"/></robot>'
    pairs = ulna.load(ARM, srdf=changed("</robot>", more)).srdf.disabled_collisions[2:]
    assert [(pair.link_a, pair.link_b, pair.reason) for pair in pairs] == [
        ("hand", "base", "Default"),
        ("hand", "finger", "Default"),
    ]


def test_a_pair_that_is_enabled_and_disabled_is_disabled_as_in_moveit():
    more = '<enable_collisions link1="base" link2="hand"/></robot>'
    assert len(ulna.load(ARM, srdf=changed("</robot>", more)).srdf.disabled_collisions) == 2


def test_an_srdf_can_be_a_xacro_file():
    text = changed('<robot name="arm">', '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">')
    assert ulna.load(ARM, srdf=changed('"1.5"', '"${pi/2}"', text)).named_configurations["arm/up"][0] == pytest.approx(1.5707963)


@pytest.mark.parametrize(
    ("srdf", "error", "message"),
    [
        (3, InputError, "srdf: int; a path or SRDF text is expected"),
        (" ", InputError, "srdf: an empty string; a path or SRDF text is expected"),
        ("gone.srdf", FileError, "gone.srdf: no such file"),
        ("<robot", DescriptionError, "SRDF text:1: not XML: "),
    ],
)
def test_an_argument_that_is_not_an_srdf_is_refused(srdf, error, message):
    with pytest.raises(error, match=f"^{re.escape(message)}"):
        ulna.load(ARM, srdf=srdf)


def test_an_element_that_is_not_known_is_said_and_those_of_other_programs_are_not():
    elements = '<disable_collision link1="base" link2="hand"/><gripper name="g"/><link_sphere_approximation link="base"/>'
    with pytest.warns(ulna.DescriptionWarning, match=r"<disable_collision> in <robot> .* did you mean 'disable_collisions'\?$"):
        robot = ulna.load(ARM, srdf=f'<robot name="arm">{elements}</robot>')
    assert len(robot.srdf.warnings) == 1
