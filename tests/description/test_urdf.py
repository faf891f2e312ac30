"""URDF: how each element is read, with numbers computed by hand; and random damage to the text."""

import re
import warnings
from math import cos, inf, pi, sin

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import ulna
from ulna import Box, Capsule, Cylinder, DescriptionWarning, Mesh, Sphere, UlnaError
from ulna.description.names.by_name import BUNDLED
from ulna.description.robot_description import JointType, Limits, Mimic

JOINT = """<robot name="one">
  <link name="base"/>
  <link name="hand"/>
  <joint name="wrist" type="{type}"><parent link="base"/><child link="hand"/>{more}</joint>
</robot>"""
PANDA = BUNDLED["panda"].text().decode()


def one_joint(kind: str, more: str = ""):
    return ulna.load(JOINT.format(type=kind, more=more))


def test_the_rotation_of_an_origin_is_rz_ry_rx():
    (joint,) = one_joint("fixed", '<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>').description.joints
    Rx = np.array([[1, 0, 0], [0, cos(0.1), -sin(0.1)], [0, sin(0.1), cos(0.1)]])
    Ry = np.array([[cos(0.2), 0, sin(0.2)], [0, 1, 0], [-sin(0.2), 0, cos(0.2)]])
    Rz = np.array([[cos(0.3), -sin(0.3), 0], [sin(0.3), cos(0.3), 0], [0, 0, 1]])
    np.testing.assert_allclose(joint.origin[:3, :3], Rz @ Ry @ Rx, atol=1e-15)
    np.testing.assert_array_equal(joint.origin[:, 3], [1, 2, 3, 1])


def test_missing_attributes_have_the_defaults_of_the_format():
    (joint,) = one_joint("continuous").description.joints
    np.testing.assert_array_equal(joint.origin, np.eye(4))
    np.testing.assert_array_equal(joint.axis, [1, 0, 0])
    assert joint.limits == Limits(-inf, inf, inf, inf)
    assert joint.mimic is None
    (joint,) = one_joint("revolute", '<limit effort="1" velocity="2"/>').description.joints
    assert joint.limits == Limits(0.0, 0.0, 2.0, 1.0)


def test_an_empty_origin_is_the_identity_and_a_material_in_a_geometry_is_ignored():
    (joint,) = one_joint("fixed", "<origin/>").description.joints
    np.testing.assert_array_equal(joint.origin, np.eye(4))
    geometry = '<geometry><material name="black"/><sphere radius="0.1"/></geometry>'
    (link,) = ulna.load(f'<robot name="r"><link name="a"><visual>{geometry}</visual></link></robot>').description.links
    assert link.visuals[0].shape == Sphere(0.1)


def test_an_axis_is_normalised():
    (joint,) = one_joint("continuous", '<axis xyz="0 3 -4"/>').description.joints
    np.testing.assert_allclose(joint.axis, [0, 0.6, -0.8], atol=1e-16)


def test_a_zero_axis_is_accepted_for_joints_without_an_axis():
    robot = one_joint("fixed", '<origin xyz="0 0 0.107"/><axis xyz="0 0 0"/>')
    np.testing.assert_array_equal(robot.forward_kinematics([])[:3, 3], [0, 0, 0.107])
    assert one_joint("floating", '<axis xyz="0 0 0"/>').n_dof == 6


@pytest.mark.filterwarnings("ignore:.*lower and upper of a continuous joint are not used")
@pytest.mark.parametrize(
    ("kind", "n_dof"), [("fixed", 0), ("revolute", 1), ("continuous", 1), ("prismatic", 1), ("planar", 3), ("floating", 6)]
)
def test_each_joint_type_has_its_number_of_entries_in_q(kind, n_dof):
    robot = one_joint(kind, '<limit lower="-1" upper="2"/>')
    assert robot.n_dof == n_dof
    assert robot.joint_slices == ((slice(0, n_dof),) if n_dof else ())
    bounded = kind in (JointType.REVOLUTE, JointType.PRISMATIC)
    np.testing.assert_array_equal(robot.lower, [-1.0 if bounded else -inf] * n_dof)
    np.testing.assert_array_equal(robot.upper, [2.0 if bounded else inf] * n_dof)


def test_q_is_in_depth_first_order_and_links_in_file_order():
    joint = '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{2}"/></joint>'
    edges = [("tip", "c", "d"), ("left", "a", "b"), ("right", "a", "c"), ("thumb", "b", "e")]
    links = "".join(f'<link name="{name}"/>' for name in "edcba")
    robot = ulna.load(f'<robot name="r">{"".join(joint.format(*edge) for edge in edges)}{links}</robot>')
    assert robot.joint_names == ("left", "thumb", "right", "tip")
    assert robot.link_names == tuple("edcba")
    assert (robot.base, robot.tip) == ("a", None)


def test_a_link_that_no_joint_moves_is_no_tip_beside_one_that_a_joint_moves():
    joint = '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>{4}</joint>'
    mimic = '<mimic joint="turn" multiplier="0.5"/>'
    joints = [
        joint.format("controller", "fixed", "base_link", "base", ""),
        joint.format("turn", "continuous", "base_link", "arm", ""),
        joint.format("follow", "continuous", "arm", "wrist", mimic),
        joint.format("flange", "fixed", "wrist", "tool0", ""),
    ]
    links = "".join(f'<link name="{name}"/>' for name in ("base_link", "base", "arm", "wrist", "tool0"))
    robot = ulna.load(f'<robot name="r">{links}{"".join(joints)}</robot>')
    assert robot.tip == "tool0"
    assert robot.with_tool(ulna.pose(xyz=(0, 0, 1)), name="gripper").tip == "gripper"
    standing = ulna.load(f'<robot name="r"><link name="base_link"/><link name="base"/>{joints[0]}</robot>')
    assert standing.tip == "base"


def test_nested_mimics_are_composed():
    joint = '<joint name="{0}" type="prismatic"><parent link="{1}"/><child link="{0}"/><limit lower="-9" upper="9"/>{2}</joint>'
    follow_a = '<mimic joint="a" multiplier="2" offset="0.1"/>'
    follow_b = '<mimic joint="b" multiplier="-3" offset="0.5"/>'
    joints = joint.format("a", "root", "") + joint.format("b", "root", follow_a) + joint.format("c", "root", follow_b)
    robot = ulna.load('<robot name="r"><link name="root"/><link name="a"/><link name="b"/><link name="c"/>' + joints + "</robot>")
    assert robot.description.joints[1].mimic == Mimic("a", 2.0, 0.1)
    assert robot.joint_names == ("a",)
    x = [robot.forward_kinematics([0.25], link=name)[0, 3] for name in "abc"]
    np.testing.assert_allclose(x, [0.25, 0.6, -3 * 0.6 + 0.5], atol=1e-15)


SHAPES = {
    '<box size="0.1 0.2 0.3"/>': Box((0.1, 0.2, 0.3)),
    '<sphere radius="0.1"/>': Sphere(0.1),
    '<cylinder radius="0.1" length="0.2"/>': Cylinder(0.1, 0.2),
    '<capsule radius="0.1" length="0.2"/>': Capsule(0.1, 0.2),
    '<mesh filename="package://arm/hand.stl"/>': Mesh("package://arm/hand.stl"),
    '<mesh filename="hand.stl" scale="0.001 -0.001 0.001"/>': Mesh("hand.stl", (0.001, -0.001, 0.001)),
}


@pytest.mark.parametrize("element", SHAPES)
def test_a_shape_is_read_with_its_dimensions(element):
    body = f'<origin xyz="1 0 0" rpy="0 0 {pi / 2!r}"/><geometry>{element}</geometry>'
    text = f'<robot name="r"><link name="a"><collision name="palm">{body}</collision><visual>{body}</visual></link></robot>'
    (link,) = ulna.load(text).description.links
    (collision,), (visual,) = link.collisions, link.visuals
    assert (collision.name, collision.shape, visual.name, visual.shape) == ("palm", SHAPES[element], "a_visual", SHAPES[element])
    np.testing.assert_allclose(collision.pose, [[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-15)


def test_a_material_can_be_defined_after_its_use():
    visual = '<visual><geometry><sphere radius="1"/></geometry><material name="{0}">{1}</material></visual>'
    own = visual.format("mine", '<color rgba="0 1 0 0.5"/>')
    link = f'<link name="a">{visual.format("red", "")}{own}{visual.format("unknown", "")}</link>'
    (link,) = ulna.load(
        f'<robot name="r">{link}<material name="red"><color rgba="1 0 0 1"/></material></robot>'
    ).description.links
    assert [body.color for body in link.visuals] == [(1, 0, 0, 1), (0, 1, 0, 0.5), None]
    assert [body.name for body in link.visuals] == ["a_visual_1", "a_visual_2", "a_visual_3"]


def test_a_chain_of_a_thousand_links_needs_no_recursion():
    links = "".join(f'<link name="l{k}"/>' for k in range(1001))
    joint = '<joint name="j{1}" type="fixed"><origin xyz="0 0 0.001"/><parent link="l{0}"/><child link="l{1}"/></joint>'
    joints = "".join(joint.format(k, k + 1) for k in reversed(range(1000)))
    robot = ulna.load(f'<robot name="r">{links}{joints}</robot>')
    np.testing.assert_allclose(robot.forward_kinematics([])[:3, 3], [0, 0, 1], atol=1e-12)


FRAGMENTS = [
    "",
    "nan",
    "-1",
    "1e999",
    "1e308",
    "0 0 0",
    "${x}",
    "<",
    ">",
    '"',
    "/>",
    "&amp;",
    "&x;",
    "<!-- ",
    "<?x?>",
    "<link/>",
    "\0",
]
VALUES = [match.span(1) for match in re.finditer('="([^"]*)"', PANDA)]


def assert_loads_or_raises_ulna_error(text: str) -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DescriptionWarning)  # of what is left out
            robot = ulna.load(text)
        poses = robot.link_poses(robot.home)
    except UlnaError as error:
        assert str(error)  # noqa: PT017
        return
    assert poses.shape == (len(robot.link_names), 4, 4)
    assert np.isfinite(poses).all()


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(
    st.integers(0, len(PANDA)), st.integers(0, 400), st.one_of(st.sampled_from(FRAGMENTS), st.text(max_size=8), st.integers(1, 3))
)
@example(PANDA.index("<box"), 0, "<?x?>")
def test_a_damaged_panda_loads_or_raises_an_ulna_error(start, length, fragment):
    span = PANDA[start : start + length]
    put = span * fragment if isinstance(fragment, int) else fragment
    assert_loads_or_raises_ulna_error(PANDA[:start] + put + PANDA[start + length :])


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(st.sampled_from(VALUES), st.one_of(st.sampled_from(VALUES), st.sampled_from(FRAGMENTS)))
@example((PANDA.index("0 0 0.333"), PANDA.index("0 0 0.333") + 9), "1e308 1e308 1e308")
def test_a_panda_with_an_exchanged_value_loads_or_raises_an_ulna_error(span, value):
    put = PANDA[slice(*value)] if isinstance(value, tuple) else value
    assert_loads_or_raises_ulna_error(PANDA[: span[0]] + put + PANDA[span[1] :])


FRAMES = {
    "of Drake": '<frame name="tcp" link="b" xyz="0 0.1 0.2" rpy="0.3 0 0.5"/>',
    "of Drake, of nothing but a link": '<frame name="tcp" link="b"/>',
    "of Isaac Sim": '<fixed_frame name="tcp"><parent link="b"/><origin xyz="0 0.1 0.2" rpy="0.3 0 0.5"/></fixed_frame>',
    "of a frame": '<frame name="rim" link="b" xyz="0 0.1 0"/><frame name="tcp" link="rim" xyz="0 0 0.2" rpy="0.3 0 0.5"/>',
}
ARM = '<link name="a"/><link name="b"/><joint name="tcp_fixed" type="continuous"><parent link="a"/><child link="b"/></joint>'


@pytest.mark.parametrize("name", FRAMES)
def test_a_named_frame_is_a_link_without_shapes_on_a_fixed_joint(name, recwarn):
    arm = ulna.load(f'<robot name="t">{ARM}{FRAMES[name]}</robot>')
    place = 'xyz="0 0.1 0.2" rpy="0.3 0 0.5"' if "0.2" in FRAMES[name] else ""
    joint = f'<joint name="f" type="fixed"><parent link="b"/><child link="tcp"/><origin {place}/></joint>'
    same = ulna.load(f'<robot name="t">{ARM}<link name="tcp"/>{joint}</robot>')
    assert not recwarn.list
    assert arm.tip == same.tip == "tcp"
    for q in ([0.0], [0.7]):
        assert np.allclose(arm.forward_kinematics(q), same.forward_kinematics(q), rtol=0.0, atol=1e-15)
    again = ulna.load(arm.to_urdf())
    assert np.array_equal(again.forward_kinematics([0.7]), arm.forward_kinematics([0.7]))
    assert again.link_names == arm.link_names


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        ('<frame name="tcp" link="c"/>', "<frame> 'tcp': link 'c' is not defined"),
        ('<frame name="b" link="a"/>', "<frame> 'b' has the name of a link"),
        ('<frame link="b"/>', "has no attribute 'name'"),
        ('<frame name="tcp" link="b" xyz="0 0"/>', "xyz"),
        ('<fixed_frame name="tcp"/>', "has no <parent>"),
        ('<frame name="tcp" link="tcp"/>', "link 'tcp' is not defined"),
    ],
)
def test_a_frame_that_is_nowhere_is_left_out_with_a_warning(frame, message):
    with pytest.warns(ulna.DescriptionWarning, match=r"this frame is left out") as told:
        arm = ulna.load(f'<robot name="t">{ARM}{frame}</robot>')
    assert message in str(told[0].message)
    assert arm.tip == "b"


@pytest.mark.parametrize("loop", ["loop_joint", "constraint", "ball_constraint", "linear_bushing_rpy"])
def test_a_loop_that_is_not_kept_is_warned_of(loop):
    with pytest.warns(ulna.DescriptionWarning, match=f"<{loop}> in <robot> is not read: it closes a loop of joints"):
        ulna.load(f'<robot name="t">{ARM}<{loop} name="l" type="revolute"/></robot>')
