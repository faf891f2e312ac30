"""Malformed descriptions: one valid document, one defect at a time, and the error message of each."""

from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="hand">
    <collision>
      <geometry><box size="1 1 1"/></geometry>
    </collision>
  </link>
  <link name="finger"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="hand"/>
    <origin xyz="0 0 1" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="2" effort="3"/>
  </joint>
  <joint name="grip" type="prismatic">
    <parent link="hand"/>
    <child link="finger"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.1"/>
    <mimic joint="shoulder" multiplier="0.1"/>
  </joint>
</robot>
"""
SHOULDER_LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="3"/>'
GRIP_MIMIC = '<mimic joint="shoulder" multiplier="0.1"/>'
BOX = '<box size="1 1 1"/>'
KNOWN_TYPES = "'fixed', 'revolute', 'continuous', 'prismatic', 'planar', 'floating'"


def changed(*replacements: str) -> str:
    text = ARM
    for old, new in zip(replacements[::2], replacements[1::2], strict=True):
        assert text.count(old) >= 1, f"{old!r} is not in the valid document"
        text = text.replace(old, new, 1)
    return text


def refusal(tmp_path: Path, document: str | bytes) -> DescriptionError:
    file = tmp_path / "arm.urdf"
    file.write_bytes(document if isinstance(document, bytes) else document.encode())
    with pytest.raises(DescriptionError) as caught:
        ulna.load(file)
    return caught.value


# fmt: off
DEFECTS = {
    # ---- elements and attributes that are missing or unknown
    "a root that is not a robot": (2,
        "the root element is <gazebo>, not <robot>: this is not a URDF but SDF of before 1.3, which is not read; 1.4 is",
        ARM, "<!-- -->\n<gazebo><model/></gazebo>"),
    "a link without a name": (2, "<link> has no attribute 'name'", '<link name="base"/>', "<link/>"),
    "a joint without a name": (9, "<joint> has no attribute 'name'", ' name="shoulder"', ""),
    "a joint without a type": (9, "<joint> has no attribute 'type'", ' type="revolute"', ""),
    "a joint without a parent": (9, "<joint> 'shoulder' has no <parent>", '<parent link="base"/>', ""),
    "a joint without a child": (9, "<joint> 'shoulder' has no <child>", '<child link="hand"/>', ""),
    "an empty document of a robot": (None, "the robot has no links", ARM, "<robot name='arm'/>"),
    "a mistyped root": (1, "the root element is <robt>, not <robot>: this is not a URDF", ARM, "<robt></robt>"),
    "a child that names no link": (11, "<child> has no attribute 'link'", '<child link="hand"/>', "<child/>"),
    "an axis without a direction": (13, "<axis> has no attribute 'xyz'", '<axis xyz="0 0 1"/>', "<axis/>"),
    "a box without a size": (5, "<box> has no attribute 'size'", BOX, "<box/>"),
    "a sphere without a radius": (5, "<sphere> has no attribute 'radius'", BOX, "<sphere/>"),
    "a cylinder without a radius": (5, "<cylinder> has no attribute 'radius'", BOX, '<cylinder length="1"/>'),
    # ---- elements that occur twice
    "a joint with two parents": (10, "<joint> 'shoulder' has 2 <parent>; one is expected", '<parent link="base"/>',
        '<parent link="base"/><parent link="finger"/>'),
    "a joint with two origins": (13, "<joint> 'shoulder' has 2 <origin>; one is expected", '<axis xyz="0 0 1"/>',
        '<origin xyz="1 0 0"/>'),
    "a joint with two limits": (14, "<joint> 'shoulder' has 2 <limit>; one is expected", SHOULDER_LIMIT, 2 * SHOULDER_LIMIT),
    "a joint that mimics twice": (21, "<joint> 'grip' has 2 <mimic>; one is expected", GRIP_MIMIC, 2 * GRIP_MIMIC),
    "a collision shape with two geometries": (5, "<collision> has 2 <geometry>; one is expected", f"<geometry>{BOX}</geometry>",
        2 * f"<geometry>{BOX}</geometry>"),
    "a geometry of two shapes": (5, "link 'hand': one <geometry> has 2 shapes; one is expected",
        BOX, BOX + '<sphere radius="1"/>'),
    "a parent that names no link": (10, "<parent> has no attribute 'link'", '<parent link="base"/>', "<parent/>"),
    "a mistyped joint type": (9,
        "joint 'shoulder': type 'revolut' is not known; did you mean 'revolute'?", "revolute", "revolut"),
    "a joint type of another format": (9,
        f"joint 'shoulder': type 'ball' is not known; there are {KNOWN_TYPES}", "revolute", "ball"),
    "a cylinder without a length": (5, "<cylinder> has no attribute 'length'", BOX, '<cylinder radius="1"/>'),
    "a mesh without a file": (5, "<mesh> has no attribute 'filename'", BOX, "<mesh/>"),
    # ---- numbers
    "NaN in an origin": (12, "<origin> xyz='nan 0 1': 3 finite numbers expected", 'xyz="0 0 1"', 'xyz="nan 0 1"'),
    "infinity in an origin": (12, "<origin> rpy='0 -inf 0': 3 finite numbers expected", 'rpy="0 0 0"', 'rpy="0 -inf 0"'),
    "a number beyond float64": (12, "<origin> xyz='1e400 0 1': 3 finite numbers expected", 'xyz="0 0 1"', 'xyz="1e400 0 1"'),
    "two numbers for three": (12, "<origin> xyz='0 1': 3 finite numbers expected", 'xyz="0 0 1"', 'xyz="0 1"'),
    "four numbers for three": (13, "<axis> xyz='0 0 1 0': 3 finite numbers expected", '<axis xyz="0 0 1"', '<axis xyz="0 0 1 0"'),
    "hexadecimal text": (14, "<limit> lower='0xff': not numbers", 'lower="-1"', 'lower="0xff"'),
    "commas between numbers": (12, "<origin> xyz='0,0,1': not numbers", 'xyz="0 0 1"', 'xyz="0,0,1"'),
    "an underscore, which only Python reads": (12, "<origin> xyz='1_0 0 1': not numbers", 'xyz="0 0 1"', 'xyz="1_0 0 1"'),
    "an expression without xacro": (12,
        "<origin> rpy='${pi} 0 0': not numbers (an expression: is this a xacro file without its xmlns:xacro?)",
                                    'rpy="0 0 0"', 'rpy="${pi} 0 0"'),
    "a box of negative size": (5, "<box> size='1 -1 1': 3 finite numbers of at least 0 expected", BOX, '<box size="1 -1 1"/>'),
    "a sphere of negative radius": (5,
        "<sphere> radius='-1': 1 finite number of at least 0 expected", BOX, '<sphere radius="-1"/>'),
    "NaN as a mimic's multiplier": (21,
        "<mimic> multiplier='nan': 1 finite number expected", 'multiplier="0.1"', 'multiplier="nan"'),
    # ---- axes and limits
    "a revolute joint about no axis": (9, "joint 'shoulder': axis (0.0, 0.0, 0.0) has no direction, but the joint is revolute",
                                       '<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'),
    "a prismatic joint along no axis": (16, "joint 'grip': axis (0.0, 0.0, 0.0) has no direction, but the joint is prismatic",
                                        '<axis xyz="1 0 0"/>', '<axis xyz="0 0 0"/>'),
    "a revolute joint without limits": (9,
        "joint 'shoulder': a revolute joint needs a <limit>; a joint without limits is of type 'continuous'",
                                        SHOULDER_LIMIT, ""),
    "a prismatic joint without limits": (16, "joint 'grip': a prismatic joint needs a <limit>",
                                         '<limit lower="0" upper="0.1"/>', "", GRIP_MIMIC, ""),
    "limits the wrong way round": (14, "joint 'shoulder': lower limit 2.0 is above upper limit 1.0", 'lower="-1"', 'lower="2"'),
    # ---- the tree
    "a mistyped parent": (9,
        "joint 'shoulder': parent link 'bse' is not defined; did you mean 'base'?", 'parent link="base"', 'parent link="bse"'),
    "an undefined child": (9, "joint 'shoulder': child link 'elbow' is not defined; there are 'base', 'hand', 'finger'",
                           'child link="hand"', 'child link="elbow"'),
    "a link with two parents": (16,
        "link 'hand' is the child of two joints, 'shoulder' and 'grip': closed loops are not supported",
                                'child link="finger"', 'child link="hand"'),
    "a loop beside the root": (9, "joint 'shoulder' is part of a loop of joints that the root does not reach",
                               'parent link="base"', 'parent link="finger"'),
    "a joint from a link to itself": (16, "joint 'grip' is part of a loop of joints that the root does not reach",
                                      'parent link="hand"', 'parent link="finger"'),
    "a loop of everything": (None, "every link is the child of some joint: the joints form a loop",
                             '<link name="base"/>', "", 'parent link="base"', 'parent link="finger"'),
    "several roots": (None,
        "2 links have no parent (base, lost): one root is expected", '<link name="base"/>',
        '<link name="base"/><link name="lost"/>'),
    "no links": (None, "the robot has no links", ARM, "<robot/>"),
    "a link defined twice": (8, "link 'base' is defined twice", 'link name="finger"', 'link name="base"'),
    "a joint defined twice": (16, "joint 'shoulder' is defined twice", 'name="grip"', 'name="shoulder"'),
    # ---- mimics
    "a mimic of an undefined joint": (16, "joint 'grip' mimics 'sholder', which is not defined; did you mean 'shoulder'?",
                                      'mimic joint="shoulder"', 'mimic joint="sholder"'),
    "a mimic of a ratio beyond all use": (16,
        "joint 'grip' follows at a ratio of 1.1e+06, off by 0: beyond 1e+06 angles lose their digits",
                                          'multiplier="0.1"', 'multiplier="1.1e6"'),
    "a mimic of an offset beyond all use": (16,
        "joint 'grip' follows at a ratio of 0.1, off by -1e+300: beyond 1e+06 angles lose their digits",
                                            'multiplier="0.1"', 'multiplier="0.1" offset="-1e300"'),
    "a mimic of itself": (16, "joints grip -> grip mimic each other in a circle", 'mimic joint="shoulder"', 'mimic joint="grip"'),
    "mimics in a circle": (16, "joints shoulder -> grip -> shoulder mimic each other in a circle",
                           '<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><mimic joint="grip"/>'),
    "a mimic of a planar joint": (16,
        "joint 'grip' mimics 'shoulder', a planar joint: no single number to follow", "revolute", "planar"),
    "a planar joint that mimics": (21, "joint 'grip': a planar joint cannot mimic another", "prismatic", "planar"),
    "a mimic of nothing": (21, "<mimic> has no attribute 'joint'", GRIP_MIMIC, "<mimic/>"),
}
# fmt: on


def test_the_document_without_a_defect_is_valid():
    assert ulna.load(ARM).n_dof == 1


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_is_reported_with_its_file_and_line(tmp_path, name):
    line, message, *replacements = DEFECTS[name]
    error = refusal(tmp_path, changed(*replacements))
    assert str(error) == (f"arm.urdf: {message}" if line is None else f"arm.urdf:{line}: {message}")
    assert (error.source, error.line, error.message) == ("arm.urdf", line, message)
    assert isinstance(error, ValueError)


@pytest.mark.parametrize("digits", ["\u0663", "\uff11"], ids=["Arabic-Indic", "fullwidth"])
def test_non_ascii_digits_are_refused(tmp_path, digits):
    assert refusal(tmp_path, changed('xyz="0 0 1"', f'xyz="{digits} 0 1"')).line == 12


@pytest.mark.parametrize("axis", ["1e200 1e200 0", "1e-300 0 0"], ids=["overflowing", "underflowing"])
def test_an_axis_of_extreme_length_is_refused_or_normalised(axis):
    document = changed('<axis xyz="0 0 1"/>', f'<axis xyz="{axis}"/>')
    try:
        (joint,) = (joint for joint in ulna.load(document).description.joints if joint.name == "shoulder")
    except DescriptionError:
        return
    assert (joint.axis @ joint.axis) == pytest.approx(1.0)
