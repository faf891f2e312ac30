"""Soft limits of a ``safety_controller``: in the description, as arrays over q, and in the URDF that is written."""

import pickle
from math import inf

import numpy as np
import pytest

import ulna
from ulna import DescriptionError
from ulna.description.robot_description import Safety
from ulna.description.urdf_writer import write_urdf

pytestmark = pytest.mark.filterwarnings("ignore:.*lower and upper of a continuous joint are not used")
JOINT = """<joint name="{name}" type="{kind}"><parent link="base"/><child link="{name}"/>
<limit lower="-1" upper="2" velocity="1" effort="1"/>{more}</joint>"""


def robot_of(*joints: tuple[str, str, str]) -> ulna.Robot:
    links = "".join(f'<link name="{name}"/>' for name, _, _ in joints)
    text = "".join(JOINT.format(name=name, kind=kind, more=more) for name, kind, more in joints)
    return ulna.load(f'<robot name="r"><link name="base"/>{links}{text}</robot>')


def safety(**soft: float) -> str:
    return '<safety_controller k_velocity="10" ' + " ".join(f'soft_{side}_limit="{x}"' for side, x in soft.items()) + "/>"


def test_a_safety_controller_is_read_with_its_gains():
    more = '<safety_controller k_velocity="10" k_position="20" soft_lower_limit="-0.9" soft_upper_limit="1.8"/>'
    (joint,) = robot_of(("a", "revolute", more)).description.joints
    assert joint.safety == Safety(k_velocity=10, k_position=20, soft_lower=-0.9, soft_upper=1.8)


def test_missing_soft_limits_are_infinite_and_the_missing_position_gain_is_zero():
    (joint,) = robot_of(("a", "revolute", safety())).description.joints
    assert joint.safety == Safety(10.0, 0.0, -inf, inf)


# The soft limits in the file of a joint with limits -1 and 2, and the resulting ones.
SOFT = {
    "within": ({"lower": -0.5, "upper": 1.5}, (-0.5, 1.5)),
    "one side only": ({"upper": 1.5}, (-1, 1.5)),
    "none": ({}, (-1, 2)),
    "wider than the limits": ({"lower": -3, "upper": 9}, (-1, 2)),
    "wholly outside the limits": ({"lower": 2.5, "upper": 9}, (-1, 2)),
    "at the border": ({"lower": 2, "upper": 9}, (2, 2)),
}


@pytest.mark.parametrize("name", SOFT)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_soft_limits_narrow_the_limits_and_never_widen_them(kind, name):
    said, expected = SOFT[name]
    robot = robot_of(("a", kind, safety(**said)))
    assert (robot.soft_lower[0], robot.soft_upper[0]) == expected
    assert (robot.lower[0], robot.upper[0]) == (-1, 2)


def test_without_a_controller_soft_limits_equal_the_limits():
    robot = robot_of(("a", "revolute", ""), ("b", "continuous", safety(lower=-1, upper=1)), ("c", "planar", ""))
    np.testing.assert_array_equal(robot.soft_lower, [-1, -inf, -inf, -inf, -inf])
    np.testing.assert_array_equal(robot.soft_upper, [2, inf, inf, inf, inf])


def test_the_soft_limits_of_a_mimic_narrow_those_of_its_leader():
    follower = '<mimic joint="a" multiplier="-2" offset="0.5"/>' + safety(lower=-0.5, upper=1.5)
    robot = robot_of(("a", "revolute", ""), ("b", "revolute", follower))
    assert (robot.soft_lower[0], robot.soft_upper[0]) == (-0.5, 0.5)  # -2 q + 0.5 within -0.5 and 1.5
    assert (robot.lower[0], robot.upper[0]) == (-0.75, 0.75)  # and within -1 and 2


def test_soft_limits_are_kept_by_writing_pickling_tip_and_with_tool():
    robot = robot_of(("a", "revolute", safety(lower=-0.5, upper=1.5)))
    copies = [
        ulna.load(write_urdf(robot.description)),
        pickle.loads(pickle.dumps(robot)),  # noqa: S301
        robot.with_tool(np.eye(4)),
        ulna.load(robot.to_urdf(), tip="a"),
    ]
    for copy in copies:
        assert copy.description.joints[0].safety == robot.description.joints[0].safety
        assert (copy.soft_lower[0], copy.soft_upper[0]) == (-0.5, 1.5)
        assert not copy.soft_lower.flags.writeable


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (safety(lower=1, upper=0), "joint 'a': soft lower limit 1.0 is above soft upper limit 0.0"),
        (safety(lower="nan"), "<safety_controller> soft_lower_limit='nan': 1 finite number expected"),
        ("<safety_controller/>", "<safety_controller> has no attribute 'k_velocity'"),
    ],
)
def test_an_invalid_controller_is_refused_with_its_line(more, message):
    with pytest.raises(DescriptionError) as caught:
        robot_of(("a", "revolute", more))
    assert (caught.value.message, caught.value.line) == (message, 2)
