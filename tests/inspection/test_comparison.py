"""``ulna.compare``: each kind of difference alone, on a robot of which one thing was changed."""

from dataclasses import replace

import numpy as np
import pytest

import ulna
from robot_files import EXAMPLES
from robots import every_joint
from ulna import InputError, Robot
from ulna.description.names.panda import DH_JOINT_TYPES, DH_ROWS
from ulna.inspection.differences import KINDS

ARM = """<robot name="arm">
  <link name="base"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <link name="upper"><collision><origin xyz="0 0 0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry></collision></link>
  <link name="lower"/>
  <link name="finger"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="2" effort="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="2" effort="3"/></joint>
  <joint name="grip" type="prismatic"><parent link="lower"/><child link="finger"/><origin xyz="0 0 0.5"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" velocity="2" effort="3"/><mimic joint="elbow" multiplier="0.1"/></joint>
</robot>"""
# What is written, what is written instead, and the differences that must be found and no others: (kind, where).
CHANGES = {
    "a velocity": (
        'upper="1" velocity="2"',
        'upper="1" velocity="2.5"',
        [("limits", "shoulder velocity"), ("limits", "grip velocity")],
    ),
    "a limit": ('lower="-2"', 'lower="-1.9"', [("limits", "elbow lower")]),
    "no limits at all": (
        'name="elbow" type="revolute"',
        'name="elbow" type="continuous"',
        [("type", "elbow"), ("limits", "elbow lower"), ("limits", "elbow upper")],
    ),
    "an origin": ("0 0 0.5", "0.0004 0 0.5", [("origin", "grip"), ("pose", "finger")]),
    "an axis": ("1 0 0", "0 0 1", [("axis", "grip"), ("pose", "finger")]),
    "an axis' direction": ("1 0 0", "-1 0 0", [("axis", "grip"), ("pose", "finger")]),
    "an axis' length alone": ("1 0 0", "3 0 0", []),
    "a follower": ('multiplier="0.1"', 'multiplier="0.2"', [("mimic", "grip"), ("pose", "finger")]),
    "a shape": ('<sphere radius="0.1"/>', '<box size="0.1 0.1 0.1"/>', [("visual", "base")]),
    "a measure": ("0.1 0.1 0.4", "0.1 0.1 0.5", [("collision", "upper")]),
    "a shape's place": ("0 0 0.2", "0 0 0.21", [("collision", "upper")]),
    "a shape too many": (
        '<link name="lower"/>',
        '<link name="lower"><visual><geometry><sphere radius="1"/></geometry></visual></link>',
        [("visual", "lower")],
    ),
    "a link's name": ('"finger"', '"thumb"', [("link", "finger")]),
    "a joint's name": ('"grip"', '"grasp"', [("joint", "grip"), ("joint", "grasp")]),
    "a parent": ('<parent link="upper"/>', '<parent link="base"/>', [("parent", "elbow"), ("pose", "lower"), ("pose", "finger")]),
}


def found(comparison):
    return [(difference.kind, difference.where) for difference in comparison.differences]


@pytest.mark.filterwarnings("ignore:.*of a continuous joint are not used:ulna.DescriptionWarning")
@pytest.mark.parametrize("name", CHANGES)
def test_one_change_is_found_where_it_is_and_nothing_else(name):
    written, instead, expected = CHANGES[name]
    assert written in ARM
    changed = ulna.load(ARM.replace(written, instead))
    assert found(ulna.compare(ulna.load(ARM), changed)) == expected
    backwards = {kind for kind, _ in found(ulna.compare(changed, ulna.load(ARM)))}
    assert backwards == {kind for kind, _ in expected}


@pytest.mark.parametrize("name", ["Panda", "every joint"])
def test_a_robot_is_the_same_as_itself(panda, name):
    robot = panda if name == "Panda" else Robot(every_joint())
    comparison = ulna.compare(robot, robot)
    assert comparison.same
    assert len(comparison.poses) == len(robot.link_names)
    assert comparison.max_position_difference == 0.0
    assert comparison.max_rotation_difference == 0.0


def test_the_bundled_panda_is_where_that_of_example_robot_data_does(panda):
    other = ulna.load(EXAMPLES / "panda_description/urdf/panda.urdf")
    comparison = ulna.compare(panda, other)
    assert {kind for kind, _ in found(comparison)} == {"link", "joint", "collision", "visual"}
    assert len(comparison.poses) == 9
    assert comparison.max_position_difference < 1e-12
    assert ulna.compare(panda, other, ignore=["link", "joint", "visual", "collision"]).same


def test_four_tenths_of_a_millimeter_between_a_table_and_a_urdf_are_found(panda):
    rows = np.array(DH_ROWS)
    rows[8, 1] += 4e-4
    comparison = ulna.compare(panda, Robot.from_dh(rows, joint_types=DH_JOINT_TYPES))
    assert comparison.matched_by == "order"
    assert comparison.max_position_difference == pytest.approx(4e-4)
    assert comparison.max_rotation_difference < 1e-7
    [pose] = [pose for pose in comparison.poses if pose.position > 1e-9]
    assert (pose.link_a, pose.link_b) == ("panda_ee", "link9")
    assert ("pose", "panda_ee") in found(comparison)


@pytest.mark.parametrize(
    ("name", "written", "instead", "amount"),
    [
        ("position_tolerance", "0 0 0.5", "0 0 0.501", 1e-3),
        ("rotation_tolerance", 'xyz="0 0 0.5"', 'xyz="0 0 0.5" rpy="0.001 0 0"', 1e-3),
        ("limit_tolerance", 'lower="-2"', 'lower="-1.999"', 1e-3),
    ],
)
def test_a_tolerance_decides_on_both_sides_of_its_border(name, written, instead, amount):
    pair = ulna.load(ARM), ulna.load(ARM.replace(written, instead))
    assert ulna.compare(*pair, **{name: 1.01 * amount}).same
    assert not ulna.compare(*pair, **{name: 0.99 * amount}).same


def test_the_order_of_q_and_of_the_links_is_reported():
    robot = every_joint()
    links = Robot(replace(robot, links=(*robot.links[1:], robot.links[0])))
    assert found(ulna.compare(Robot(robot), links)) == [("order", "links")]
    by_name = {joint.name: joint for joint in robot.joints}
    swapped = [by_name[name] for name in ("float", "rotor joint", *(n for n in by_name if n not in ("float", "rotor joint")))]
    comparison = ulna.compare(Robot(robot), Robot(replace(robot, joints=tuple(swapped))))
    assert found(comparison) == [("order", "q")]
    assert comparison.max_position_difference < 1e-12


def test_a_robot_on_a_stand_is_compared_from_its_own_base():
    stand = ARM.replace("</robot>", """<link name="world"/><joint name="stand" type="fixed"><parent link="world"/>
      <child link="base"/><origin xyz="1 2 3"/></joint></robot>""")  # fmt: skip
    for pair in ((ARM, stand), (stand, ARM)):
        comparison = ulna.compare(*map(ulna.load, pair))
        assert (comparison.frame_a, comparison.frame_b) == ("base", "base")
        assert sorted(found(comparison)) == [("joint", "stand"), ("link", "world")]


def test_every_kind_that_is_found_can_be_ignored():
    assert {kind for _, _, expected in CHANGES.values() for kind, _ in expected} | {"order"} == set(KINDS)
    written, instead, expected = CHANGES["an origin"]
    pair = ulna.load(ARM), ulna.load(ARM.replace(written, instead))
    assert found(ulna.compare(*pair, ignore=["pose"])) == expected[:1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ignore": ["poses"]}, r"ignore: 'poses' is not a kind of difference; did you mean 'pose'\?"),
        ({"position_tolerance": -1.0}, r"position_tolerance: -1.0; a number of at least 0"),
        ({"limit_tolerance": np.nan}, "limit_tolerance: nan"),
        ({"limit_tolerance": "none"}, "limit_tolerance: 'none'"),
    ],
)
def test_wrong_arguments_are_refused_by_name(panda, arguments, message):
    with pytest.raises(InputError, match=f"^{message}"):
        ulna.compare(panda, panda, **arguments)


def test_what_is_no_robot_is_refused(panda):
    with pytest.raises(InputError, match=r"^b: 'panda'; a Robot is expected, as from ulna.load"):
        ulna.compare(panda, "panda")


def test_a_comparison_prints_one_line_for_each_difference():
    written, instead, _ = CHANGES["a limit"]
    shown = str(ulna.compare(ulna.load(ARM), ulna.load(ARM.replace(written, instead))))
    assert shown == "arm | arm: 1 difference\nlimits elbow lower: -2 | -1.9"
