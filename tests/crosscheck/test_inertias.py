"""Inertias of every URDF of example-robot-data and every xacro of rtb-data against Pinocchio's.

Pinocchio adds what no joint moves to the link that carries it; so does this file, by formulas of its own.
"""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import Peer
from robot_files import CHOSEN_XACROS, DEFEAT_THE_MIMIC_OPTION, RTB, example_urdfs, of_kinds, rtb_package_dirs, rtb_xacros

SMALL = 1e-12  # relative to the largest number of its kind in a body
NOT_LOADED = {"alex_psyonic_hands", "ur3", "kr210l150"}  # test_every_urdf and test_rtb_data say why
FILES = [file for file in example_urdfs() if file.stem not in NOT_LOADED]
XACROS = [file for file in rtb_xacros() if file.stem not in NOT_LOADED]


def about_origin(mass, center, tensor):
    """A spatial inertia, shape (6, 6): Featherstone 2008, equation 2.63, linear first as Pinocchio has it."""
    x, y, z = center
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[mass * np.eye(3), -mass * cross], [mass * cross, tensor - mass * cross @ cross]])


def in_frame(T, spatial):
    """The spatial inertia of a body in another frame, in which its own has the pose T."""
    motion = pin.SE3(T).inverse().toActionMatrix()
    return motion.T @ spatial @ motion


def by_joint(robot):
    """The spatial inertia of what each joint carries, in the frame of its child; that of the root by its name."""
    T, head = {robot.base: np.eye(4)}, {robot.base: robot.base}
    waiting = list(robot.description.joints)
    while waiting:
        joint = waiting.pop(0)
        if joint.parent not in head:
            waiting.append(joint)
            continue
        fixed = joint.type == "fixed"
        head[joint.child] = head[joint.parent] if fixed else joint.name
        T[joint.child] = T[joint.parent] @ joint.origin if fixed else np.eye(4)
    sums = {name: np.zeros((6, 6)) for name in set(head.values())}
    for link in robot.description.links:
        if link.inertia is not None:
            spatial = about_origin(link.inertia.mass, link.inertia.center, link.inertia.tensor)
            sums[head[link.name]] += in_frame(T[link.name], spatial)
    return sums


def judge(robot, model):
    """Compare with Pinocchio's, joint by joint. Returns the mass of all that moves."""
    Peer(robot, model)  # which has all joints and links of the robot
    ours = by_joint(robot)
    for name, theirs in zip(model.names[1:], model.inertias[1:], strict=True):
        expected = theirs.matrix()
        for block in np.ndindex(2, 2):
            part = np.s_[3 * block[0] : 3 * block[0] + 3, 3 * block[1] : 3 * block[1] + 3]
            scale = np.abs(expected[part]).max()
            np.testing.assert_allclose(
                ours[name][part], expected[part], rtol=0, atol=SMALL * max(scale, theirs.mass), err_msg=name
            )
    return sum(theirs.mass for theirs in model.inertias[1:])


@pytest.mark.parametrize("file", of_kinds(FILES), ids=lambda file: file.stem)
def test_what_every_joint_of_a_urdf_carries_is_pinocchios(file):
    robot = ulna.load(file)
    moving = judge(robot, pin.buildModelFromUrdf(str(file), mimic=file.stem not in DEFEAT_THE_MIMIC_OPTION))
    whole = sum(link.inertia.mass for link in robot.description.links if link.inertia is not None)
    assert 0 <= moving <= whole * (1 + 1e-9)
    assert whole > 0


@pytest.mark.skipif(RTB is None, reason="rtb-data is not installed")
@pytest.mark.parametrize("file", of_kinds(XACROS, CHOSEN_XACROS), ids=lambda file: file.name)
def test_what_every_joint_of_a_xacro_carries_is_pinocchios(file, tmp_path):
    robot = ulna.load(file, package_dirs=rtb_package_dirs(tmp_path))
    judge(robot, pin.buildModelFromXML(robot.to_urdf(), mimic=True))


@pytest.mark.parametrize("file", of_kinds(FILES), ids=lambda file: file.stem)
def test_a_urdf_that_is_written_has_the_same_inertias(file):
    robot = ulna.load(file)
    root = robot.base
    cut = ulna.load(file, base=root)  # without the text that was read
    assert not cut.description.text
    try:
        again = ulna.load(cut.to_urdf())
    except ulna.InputError as error:
        pytest.skip(str(error))  # a shape that URDF has not
    for ours, theirs in zip(robot.description.links, again.description.links, strict=True):
        assert (ours.inertia is None) == (theirs.inertia is None)
        if ours.inertia is not None and theirs.inertia is not None:
            assert ours.inertia.mass == theirs.inertia.mass
            np.testing.assert_array_equal(ours.inertia.center, theirs.inertia.center)
            np.testing.assert_array_equal(ours.inertia.tensor, theirs.inertia.tensor)
    for ours, theirs in zip(robot.description.joints, again.description.joints, strict=True):
        assert (ours.damping, ours.friction) == (theirs.damping, theirs.friction)
