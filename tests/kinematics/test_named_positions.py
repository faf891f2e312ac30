"""q of joints by name, as a ``JointState`` of ROS has them."""

import numpy as np
import pytest

import ulna
from ulna.errors import InputError

PLANAR = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="base" type="planar"><parent link="a"/><child link="b"/></joint>
<joint name="arm" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint></robot>"""


def test_names_may_be_in_any_order_and_joints_that_the_robot_lacks_are_passed_over(panda):
    order = [5, 0, 3, 6, 1, 2, 4]
    names = ["panda_finger_joint1", *(panda.joint_names[k] for k in order)]
    assert np.array_equal(panda.q_of_joints(names, [0.02, *panda.home[order]]), panda.home)


def test_joints_that_are_not_named_are_as_in_others_which_is_not_changed(panda):
    others = panda.home.copy()
    found = panda.q_of_joints(("panda_joint2",), (0.5,), others=others)
    assert np.array_equal(found, [others[0], 0.5, *others[2:]])
    assert np.array_equal(others, panda.home)


def test_a_joint_that_is_missing_is_named(panda):
    with pytest.raises(InputError, match="the joints panda_joint7 are missing; give them with others=q"):
        panda.q_of_joints(panda.joint_names[:6], panda.home[:6])


@pytest.mark.parametrize(
    ("names", "positions", "reason"),
    [
        (("panda_joint1",), (0.1, 0.2), "one position for each of 1 name"),
        (("panda_joint1",) * 2, (0.1, 0.2), "'panda_joint1' is named twice"),
        (("panda_joint1",), (np.nan,), "not a finite number"),
        ((), "text", "not an array of numbers"),
    ],
)
def test_what_does_not_go_together_is_refused(panda, names, positions, reason):
    with pytest.raises(InputError, match=reason):
        panda.q_of_joints(names, positions, others=panda.home)


def test_a_joint_of_several_positions_is_left_where_it_is():
    robot = ulna.load(PLANAR)
    assert robot.q_of_joints(["arm"], [0.5], others=[1, 2, 3, 4]).tolist() == [1, 2, 3, 0.5]
    with pytest.raises(InputError, match="'base' has several positions"):
        robot.q_of_joints(["base"], [0.5], others=[1, 2, 3, 4])
    with pytest.raises(InputError, match="others: shape"):
        robot.q_of_joints(["arm"], [0.5], others=np.zeros((2, 4)))
