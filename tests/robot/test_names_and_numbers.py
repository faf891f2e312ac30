"""Names that cannot be written, numbers that mean none, arrays with masks: refused or taken where they enter."""

import numpy as np
import pytest

import robots
import ulna
from ik_methods import valid_solutions
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link

HALF = "\ud800"


@pytest.mark.parametrize("name", [HALF, 5, None, []])
def test_a_link_or_a_joint_has_a_name_that_can_be_written(name):
    with pytest.raises(ulna.DescriptionError, match="the name of a link"):
        ulna.Robot(Description("r", (Link(name),), ()))
    joint = Joint(name, JointType.FIXED, "a", "b", np.eye(4), robots.Z)
    with pytest.raises(ulna.DescriptionError, match="the name of a joint"):
        ulna.Robot(Description("r", (Link("a"), Link("b")), (joint,)))


@pytest.mark.parametrize("name", [HALF, 5, None, []])
def test_a_tool_and_what_is_held_have_names_that_can_be_written(panda, name):
    for make in (lambda: panda.with_tool(np.eye(4), name=name), lambda: panda.with_attached(name, ulna.Sphere(0.1), np.eye(4))):
        with pytest.raises(ulna.InputError, match="name: "):
            make()


def test_masks_in_a_list_are_not_lost(panda):
    masked = np.ma.array(panda.home, mask=[1] * 7)
    for q in (masked, [masked, panda.home], [[panda.home], [masked]], ((masked,),)):
        with pytest.raises(ulna.InputError, match="a masked array, whose mask would be lost"):
            panda.forward_kinematics(q)


def test_the_largest_number_there_is_means_no_limit():
    largest = np.finfo(float).max
    joints = (
        Joint("p", JointType.PRISMATIC, "a", "b", np.eye(4), robots.X, Limits(-largest, largest, 1.0)),
        Joint("k", JointType.REVOLUTE, "b", "c", robots.place(0), robots.Z, Limits(-1.0, 1.0, 1.0)),
    )
    robot = ulna.Robot(Description("m", tuple(map(Link, "abc")), joints))
    assert (robot.lower[0], robot.upper[0]) == (-np.inf, np.inf)
    T = robot.forward_kinematics([0.1, 0.2])
    assert robot.inverse_kinematics(T).success  # and no warning of NumPy's: it would fail the test
    assert len(valid_solutions(robot, T))
    T[2, 3] = 9
    assert not robot.inverse_kinematics(T).success


def test_an_origin_that_is_too_far_is_refused_with_its_line():
    text = """<robot name="m"><link name="a"/><link name="b"/>
      <joint name="j" type="fixed"><parent link="a"/><child link="b"/>
        <origin xyz="5e6 0 0"/></joint></robot>"""
    with pytest.raises(ulna.DescriptionError, match=r"^URDF text:3: joint 'j': its origin is beyond 1e\+06 m$"):
        ulna.load(text)
    ball = '<collision><origin xyz="0 -2e6 0"/><geometry><sphere radius="1"/></geometry></collision>'
    with pytest.raises(ulna.DescriptionError, match=r"^URDF text:1: collision '': its origin is beyond 1e\+06 m$"):
        ulna.load(f'<robot name="m"><link name="a">{ball}</link></robot>')


@pytest.mark.parametrize("method", ["forward_kinematics", "jacobian", "manipulability", "analytical_jacobian"])
def test_the_error_about_several_tips_has_no_other_behind_it(method):
    robot = ulna.Robot(robots.every_joint())
    with pytest.raises(ulna.InputError, match="several tips") as caught:
        getattr(robot, method)(robot.home)
    assert caught.value.__context__ is None or caught.value.__suppress_context__


@pytest.mark.parametrize("bottom", [[1], [[0.0]], "a"])
def test_the_bottom_of_terrain_is_one_number(bottom):
    with pytest.raises(ulna.InputError, match="bottom"):
        ulna.HeightMap([[2, 2]], 0.1, bottom)


def test_cells_of_terrain_have_a_width():
    with pytest.raises(ulna.InputError, match="cell: 0; "):
        ulna.HeightMap([[2, 2]], 0)


@pytest.mark.parametrize("name", [[], None, 3])
def test_an_object_that_does_not_exist_is_an_unknown_name(name):
    with pytest.raises(ulna.UnknownNameError):
        ulna.World().move(name, np.eye(4))
    with pytest.raises(ulna.UnknownNameError):
        ulna.World().remove(name)
