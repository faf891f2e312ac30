"""Faulty parts on which no pose depends: they are left out with a warning, and what other parsers read is read as they do."""

import re
import warnings

import numpy as np
import pytest

import ulna
from ulna import DescriptionError, DescriptionWarning, GeometryError, Severity

BODY = """<link name="a"/><link name="b">{body}</link>
<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><origin xyz="0 0.1 0.3"/>{axis}
<limit lower="-1" upper="1" effort="{effort}" velocity="{velocity}"/></joint>{more}</robot>"""
Z, BOX = '<axis xyz="0 0 1"/>', '<geometry><box size="1 1 1"/></geometry>'
XACRO = ' xmlns:xacro="http://ros.org/wiki/xacro"'


def robot_text(root="", **parts):
    return f'<robot name="t"{root}>' + BODY.format_map(
        {"body": "", "kind": "revolute", "axis": Z, "effort": "1", "velocity": "1", "more": "", **parts}
    )


def visual(text):
    return {"body": f"<visual>{text}</visual>"}


def mesh(scale):
    return visual(f'<geometry><mesh filename="x.stl" scale="{scale}"/></geometry>')


def materials(*colors):
    return "".join(f'<material name="m{k}"><color rgba="{color}"/></material>' for k, color in enumerate(colors))


# Each with the words of its warning.
LEFT_OUT = {
    "two materials": (robot_text(**visual(BOX + materials("1 1 1 1", "1 1 0 1"))), "2 <material>: the first is used"),
    "a color of three numbers": (robot_text(**visual(BOX + materials("1 1 0"))), "this color is left out"),
    "a color without numbers": (robot_text(more='<material name="m"><color/></material>'), "this color is left out"),
    "a material of two colors": (
        robot_text(more='<material name="m"><color rgba="0 0 0 1"/><color rgba="1 1 1 1"/></material>'),
        "2 <color>: the first is used",
    ),
    "a visual with a scale of one number": (robot_text(**mesh(".00254")), "this visual is left out"),
    "a visual with a scale of four numbers": (robot_text(**mesh("1 1 1 1")), "this visual is left out"),
    "a visual of no known shape": (robot_text(**visual('<geometry><plane normal="0 0 1"/></geometry>')), "<plane> is not known"),
    "a visual with an empty geometry": (robot_text(**visual("<geometry/>")), "an empty <geometry> is not known"),
    "a visual without a geometry": (robot_text(**visual("")), "an empty <geometry> is not known"),
    "two origins of a visual": (robot_text(**visual("<origin/><origin/>" + BOX)), "has 2 <origin>; one is expected"),
    "a visual box without a size": (robot_text(**visual("<geometry><box/></geometry>")), "this visual is left out"),
    "a macro left by an expansion": (robot_text(XACRO, more="<xacro:gray/>"), "<xacro:gray> is left out: this document"),
    "a velocity of -1": (robot_text(velocity="-1"), "velocity='-1' is not a number of at least 0: treated as unlimited"),
    "a velocity that is not a number": (robot_text(velocity="nan"), "velocity='nan' is not a number"),
}
# What needs no warning of load: nothing is missing. inspect says it all the same.
QUIET = {
    "an effort of -1": robot_text(effort="-1"),
    "an infinite effort": robot_text(effort="inf"),
    "an effort in words": robot_text(effort="unknown"),
    "an infinite velocity": robot_text(velocity="inf"),
    "an undeclared prefix of another program": robot_text(more='<gazebo><sensor:camera name="c"/></gazebo>'),
    "version 0.0 of XML": '<?xml version="0.0" ?>' + robot_text(),
    "a blank line before the declaration": '\n<?xml version="1.0" ?>' + robot_text(),
    "a declaration without quotes": "<?xml version=1.0 encoding=utf-8 ?>" + robot_text(),
    "a comment before the declaration": '<!-- made by hand -->\n<?xml version="1.0"?>' + robot_text(),
}
FAULTY_AXIS = robot_text(kind="fixed", axis='<axis xzy="0 0 1"/>')


@pytest.fixture
def quietly():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)
        yield


def in_file(tmp_path, text):
    file = tmp_path / "t.urdf"
    file.write_text(text)
    return file


@pytest.mark.parametrize("name", LEFT_OUT)
def test_what_no_pose_depends_on_is_left_out_with_a_warning(name):
    text, words = LEFT_OUT[name]
    with pytest.warns(DescriptionWarning, match=r"^URDF text:\d+: .*") as caught:
        robot = ulna.load(text)
    assert words in str(caught[0].message)
    assert robot.joint_names == ("j",)


@pytest.mark.parametrize("name", QUIET)
def test_what_changes_nothing_loads_from_a_file_without_a_warning(tmp_path, name):
    assert ulna.load(in_file(tmp_path, QUIET[name])).joint_names == ("j",)


@pytest.mark.usefixtures("quietly")
@pytest.mark.parametrize("name", [*LEFT_OUT, *QUIET])
def test_its_poses_are_pinocchios(tmp_path, name):
    text = LEFT_OUT[name][0] if name in LEFT_OUT else QUIET[name]
    if name == "a comment before the declaration":
        text = robot_text()  # which urdfdom refuses
    pin = pytest.importorskip("pinocchio")
    from pinocchio_peer import Peer, farthest_link

    robot = ulna.load(in_file(tmp_path, text))
    text = re.sub(r'(effort|velocity)="[^"]*"', r'\1="1"', text)  # some of which Pinocchio refuses
    assert farthest_link(Peer(robot, pin.buildModelFromUrdf(str(in_file(tmp_path, text)), mimic=True)), 10) < 1e-12


@pytest.mark.usefixtures("quietly")
@pytest.mark.parametrize("name", [*LEFT_OUT, *QUIET])
def test_inspect_has_a_finding_that_is_no_error(tmp_path, name):
    text = LEFT_OUT[name][0] if name in LEFT_OUT else QUIET[name]
    found = ulna.inspect(in_file(tmp_path, text))
    assert found.loads
    assert not [one for one in found.findings if one.severity == Severity.ERROR]
    if name in LEFT_OUT:
        assert LEFT_OUT[name][1] in str(found)
    elif "XML" in name or "declaration" in name or "prefix" in name:
        assert "is not well-formed XML, as other programs may say" in str(found)
    else:
        assert "treated as unlimited" in str(found)


def test_a_warning_names_a_file_with_braces_in_its_name(tmp_path):
    path = tmp_path / "a{b}.urdf"
    path.write_text(LEFT_OUT["two materials"][0])
    with pytest.warns(DescriptionWarning, match=re.escape("a{b}.urdf:")):
        ulna.load(path)


def test_the_lines_of_a_mended_document_are_those_of_the_file(tmp_path):
    for head in ('\n\n<?xml version="1.0"?>', "<!-- one\ntwo -->\n<?xml version=1.0?>", '<?xml\nversion="0.0"\n?>'):
        text = head + robot_text(axis="\n\n<axis/>")
        line = text[: text.index("<axis/>")].count("\n") + 1
        with pytest.raises(DescriptionError, match=rf"^t\.urdf:{line}: <axis> has no attribute 'xyz'"):
            ulna.load(in_file(tmp_path, text))


def test_a_mended_document_is_written_well_formed(tmp_path):
    robot = ulna.load(in_file(tmp_path, "\n<?xml version=0.0 ?>" + robot_text(more="<gazebo><a:b/></gazebo>")))
    assert ulna.load(robot.to_urdf()).joint_names == ("j",)
    pin = pytest.importorskip("pinocchio")
    assert pin.buildModelFromXML(robot.to_urdf()).nq == 1


def test_the_axis_of_a_fixed_joint_is_not_read():
    with pytest.warns(DescriptionWarning, match="attribute 'xzy' of <axis> is not read"):
        assert ulna.load(FAULTY_AXIS).n_dof == 0


def test_xacro_without_its_namespace_is_xacro():
    text = '<robot name="t"><xacro:property name="n" value="a"/><link name="${n}"/></robot>'
    assert ulna.load(text).link_names == ("a",)


def test_a_call_of_a_missing_macro_in_a_xacro_file_is_refused(tmp_path):
    file = in_file(tmp_path, robot_text(XACRO, more="<xacro:gray/>")).rename(tmp_path / "t.xacro")
    with pytest.raises(DescriptionError, match="unknown macro name: xacro:gray"):
        ulna.load(file)


# ---- collision shapes that are not known: poses can be had, and no query says that they are free

UNKNOWN = {
    "a plane": ('<geometry><plane normal="0 0 1"/></geometry>', "<plane>"),
    "a mesh with a scale of four numbers": (
        '<geometry><mesh filename="x.stl" scale="1 1 1 1"/></geometry>',
        "<mesh> with scale=",
    ),
    "an empty geometry": ("<geometry/>", "an empty <geometry>"),
    "a capsule by its ends": ('<geometry><capsule sp="0 0 0" ep="0 0 1" radius="0.1"/></geometry>', "<capsule> with sp="),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_a_collision_shape_that_is_not_known_leaves_the_kinematics_and_refuses_queries(name):
    text, kind = UNKNOWN[name]
    with pytest.warns(DescriptionWarning, match="collision geometry .* is not known: poses can be computed, collisions cannot"):
        robot = ulna.load(robot_text(body=f"<collision>{text}</collision>"))
    np.testing.assert_allclose(robot.forward_kinematics([0.0])[:3, 3], [0, 0.1, 0.3])
    for query in (
        lambda: robot.in_collision([0.0]),
        lambda: robot.plan([0.0], [0.5]),
        lambda: robot.with_convex_hulls().in_collision([0.0]),
    ):
        with pytest.raises(GeometryError, match=f"link 'b': .*{kind}.* is not known, so it cannot be checked"):
            query()
