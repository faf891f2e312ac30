"""Groups and named configurations on a robot: which joints and entries of q a group has, and the q of a state."""

import copy
import pickle

import numpy as np
import pytest

import formulas
import ulna
from ulna import DescriptionError, DescriptionWarning

LINKS = "".join(f'<link name="{name}"/>' for name in ("world", "drone", "base", "a", "b", "tool", "left", "right"))
LIMIT = '<limit lower="-3" upper="3"/>'
JOINT = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>{}{}</joint>'
URDF = (
    '<robot name="r">'
    + LINKS
    + "".join(
        JOINT.format(*row)
        for row in [
            ("fly", "floating", "world", "drone", "", ""),
            ("drive", "planar", "drone", "base", "", ""),
            ("j1", "revolute", "base", "a", LIMIT, ""),
            ("j2", "revolute", "a", "b", LIMIT, ""),
            ("weld", "fixed", "b", "tool", "", ""),
            ("grip", "prismatic", "tool", "left", LIMIT, ""),
            ("follow", "prismatic", "tool", "right", LIMIT, '<mimic joint="grip" multiplier="-2" offset="0.1"/>'),
        ]
    )
    + "</robot>"
)
GROUPS = """<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group name="hand"><link name="left"/><link name="right"/><joint name="weld"/></group>
<group name="both"><group name="hand"/><group name="arm"/></group>
<group name="across"><chain base_link="left" tip_link="right"/></group>
<group name="rover"><joint name="drive"/><joint name="fly"/></group>
<group name="root"><link name="world"/></group>
<group name="ring"><group name="gnir"/><joint name="j1"/></group>
<group name="gnir"><group name="ring"/><joint name="j2"/></group>"""


def robot_with(srdf: str, **options) -> ulna.Robot:
    return ulna.load(URDF, srdf=f'<robot name="r">{srdf}</robot>', **options)


@pytest.mark.parametrize(
    ("name", "joints", "columns", "links"),
    [
        ("arm", ("j1", "j2"), (9, 10), ("a", "b", "tool")),
        ("hand", ("grip",), (11,), ("tool", "left", "right")),
        ("both", ("j1", "j2", "grip"), (9, 10, 11), ("a", "b", "tool", "left", "right")),
        ("across", ("grip",), (11,), ("left", "right")),
        ("rover", ("fly", "drive"), (0, 1, 2, 3, 4, 5, 6, 7, 8), ("drone", "base")),
        ("root", (), (), ("world",)),
        ("ring", ("j1", "j2"), (9, 10), ("a", "b")),
        ("gnir", ("j1", "j2"), (9, 10), ("a", "b")),
    ],
)
def test_a_group_has_its_joints_their_entries_of_q_and_the_links_they_move(name, joints, columns, links):
    group = robot_with(GROUPS).groups[name]
    assert (group.joint_names, group.columns, group.link_names) == (joints, columns, links)


@pytest.mark.parametrize(
    ("name", "parent"),
    [("arm", "base"), ("hand", "tool"), ("both", "base"), ("across", "tool"), ("rover", "world"), ("root", "world")],
)
def test_the_entries_of_a_group_and_no_others_move_its_links_relative_to_their_parent(name, parent):
    robot = robot_with(GROUPS)
    group, q = robot.groups[name], np.full(robot.n_dof, 0.2)

    def relative(q):
        T_base_parent, T_base_link = (robot.forward_kinematics(q, link=link) for link in (parent, group.link_names[-1]))
        return np.linalg.inv(T_base_parent) @ T_base_link

    moved = [np.abs(relative(q + 0.1 * unit) - relative(q)).max() > 1e-6 for unit in np.eye(robot.n_dof)]
    assert group.columns == tuple(np.flatnonzero(moved))


CHAIN = '<chain base_link="{}" tip_link="{}"/>'


@pytest.mark.parametrize(
    ("chains", "tips"),
    [
        ([("base", "b")], ("b",)),
        ([("base", "b"), ("base", "tool")], ("tool",)),  # the first ends in the middle of the second
        ([("base", "b"), ("b", "left")], ("left",)),  # the second goes on where the first ends
        ([("base", "left"), ("base", "right")], ("left", "right")),
        ([("base", "tool"), ("left", "right")], ("right",)),  # the second passes through the tool
        ([("base", "base")], ("base",)),
    ],
)
def test_a_link_from_which_another_chain_leads_on_is_no_tip(chains, tips):
    whole = "".join(CHAIN.format(*ends) for ends in chains)
    parts = "".join(f'<group name="p{k}">{CHAIN.format(*ends)}</group>' for k, ends in enumerate(chains))
    named = "".join(f'<group name="p{k}"/>' for k in range(len(chains)))
    robot = robot_with(f'<group name="whole">{whole}</group>{parts}<group name="of_groups">{named}</group>')
    assert robot.groups["whole"].tips == robot.groups["of_groups"].tips == tips


def test_joints_and_links_beside_a_chain_do_not_move_its_tip():
    srdf = f'<group name="g">{CHAIN.format("base", "tool")}<link name="left"/><joint name="follow"/></group>'
    assert robot_with(srdf).groups["g"].tip == "tool"


def test_a_state_is_completed_from_home_and_named_after_its_group():
    state = '<group name="arm"/><group_state name="up" group="arm"><joint name="j2" value="1.25"/></group_state>'
    robot = robot_with(state)
    expected = robot.home.copy()
    expected[10] = 1.25
    np.testing.assert_array_equal(robot.named_configurations["arm/up"], expected)
    assert not robot.named_configurations["arm/up"].flags.writeable


def test_home_is_what_completes_a_state_not_zero(panda):
    srdf = '<robot name="panda"><group_state name="turned"><joint name="panda_joint1" value="0.5"/></group_state></robot>'
    q = ulna.load("panda", srdf=srdf).named_configurations["turned"]
    np.testing.assert_array_equal(q, [0.5, *panda.home[1:]])


def test_planar_and_floating_joints_take_the_numbers_of_moveit():
    """A floating joint is x, y, z and a quaternion x, y, z, w there; here x, y, z, roll, pitch, yaw."""
    values = '<joint name="fly" value="1 2 3 0 0 7 7"/><joint name="drive" value="4 5 0.6"/>'
    q = robot_with(f'<group_state name="s">{values}</group_state>').named_configurations["s"]
    np.testing.assert_allclose(q[:9], [1, 2, 3, 0, 0, np.pi / 2, 4, 5, 0.6], atol=1e-12)
    robot = robot_with("")
    np.testing.assert_allclose(
        robot.forward_kinematics(q, link="drone"), formulas.from_rpy((1, 2, 3), (0, 0, np.pi / 2)), atol=1e-12
    )


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("0 0 0 0 0 0", "x, y, z and a quaternion x, y, z, w expected, not 0 0 0 0 0 0"),
        ("1 2 3 0 0 0 0", "expected, not 1 2 3 0 0 0 0"),
    ],
)
def test_a_floating_joint_without_a_rotation_is_refused(value, expected):
    with pytest.raises(DescriptionError, match=f"joint 'fly' is floating: .*{expected}$"):
        robot_with(f'<group_state name="s"><joint name="fly" value="{value}"/></group_state>')


def test_a_mimic_may_repeat_what_follows_from_its_leader_and_is_reported_where_it_does_not():
    state = '<group_state name="s"><joint name="grip" value="0.5"/><joint name="follow" value="{}"/></group_state>'
    assert robot_with(state.format(-0.9)).srdf.warnings == ()
    with pytest.warns(DescriptionWarning, match="joint 'follow' follows 'grip'; its own value 0.5 is ignored"):
        robot = robot_with(state.format(0.5))
    assert robot.named_configurations["s"][11] == 0.5


def test_a_part_of_a_robot_keeps_what_concerns_it_without_a_warning():
    state = '<group_state name="s" group="both"><joint name="j2" value="1"/><joint name="grip" value="2"/></group_state>'
    pair = '<disable_collisions link1="a" link2="b"/><disable_collisions link1="a" link2="left"/>'
    part = robot_with(GROUPS + state + pair, base="base", tip="b")
    assert part.groups["both"].joint_names == ("j1", "j2")
    np.testing.assert_array_equal(part.named_configurations["both/s"], [0, 1])
    assert [(p.link_a, p.link_b) for p in part.srdf.disabled_collisions] == [("a", "b")]
    assert part.srdf.warnings == ()


def test_copies_hold_the_same_and_nothing_can_be_changed():
    state = '<group_state name="s"><joint name="j2" value="1"/></group_state>'
    robot = robot_with(GROUPS + state)
    assert robot.groups["arm"].columns  # computed before the copy
    for twin in (pickle.loads(pickle.dumps(robot)), copy.deepcopy(robot), robot_with(GROUPS + state)):  # noqa: S301
        assert twin.groups == robot.groups
        np.testing.assert_array_equal(twin.named_configurations["s"], robot.named_configurations["s"])
    with pytest.raises(TypeError):
        robot.groups["arm"] = None
    with pytest.raises(TypeError):
        robot.named_configurations["s"] = None


def test_a_tool_leaves_the_groups_as_they_are():
    panda = ulna.load("panda", srdf='<robot name="p"><group name="g"><joint name="panda_joint3"/></group></robot>')
    assert panda.with_tool(np.eye(4)).groups["g"].columns == (2,)


def test_a_virtual_joint_does_not_hide_a_joint_of_its_name():
    virtual = '<virtual_joint name="j2" type="fixed" parent_frame="map" child_link="world"/>'
    robot = robot_with(virtual + '<group_state name="s"><joint name="j2" value="1"/></group_state>')
    assert robot.named_configurations["s"][10] == 1
