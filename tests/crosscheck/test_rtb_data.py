"""The xacro robots of rtb-data (iiwa14, Kuka and ABB arms, the Interbotix arms, the Puma ...) against Pinocchio.

Their macros, arguments, includes and packages are expanded without ROS; Pinocchio reads the text that comes of it.
"""

import pinocchio as pin
import pytest

import ulna
from pinocchio_forces import differences, with_all_inertias
from pinocchio_peer import Peer, farthest_jacobian, farthest_link
from robot_files import CHOSEN_XACROS, RTB, XACROS, installed, of_kinds, rtb_package_dirs, rtb_xacros
from ulna import DescriptionError
from ulna.bench.arms import load_arm

pytestmark = pytest.mark.skipif(RTB is None, reason="rtb-data is not installed")
BROKEN = {"kr210l150.xacro": r"^kr210l150\.xacro: xacro: name 'deg' is not defined when evaluating expression '-185\*deg'"}
N_DOF = {"lbr_iiwa_14_r820.xacro": 7, "puma560_robot.urdf.xacro": 6, "irb140.xacro": 6, "xarm6.xacro": 6, "kr5_arc.xacro": 6}

FILES = [file for file in rtb_xacros() if file.name not in BROKEN]


@pytest.fixture(scope="module")
def package_dirs(tmp_path_factory):
    return rtb_package_dirs(tmp_path_factory.mktemp("packages"))


def test_there_are_as_many_files_as_the_package_had_when_this_was_written():
    names = {file.name for file in rtb_xacros()}
    assert len(names) == 41
    assert names >= {*BROKEN, *N_DOF}
    assert {file for file in rtb_xacros() if not file.is_file()} == set()


def test_one_that_a_newer_version_of_the_package_adds_can_be_loaded(package_dirs):
    for name in installed(RTB, ".xacro") - set(XACROS.split()):
        assert ulna.load(RTB / name, package_dirs=package_dirs).link_names, name


@pytest.mark.parametrize("file", of_kinds(FILES, CHOSEN_XACROS), ids=lambda file: file.name)
def test_a_robot_is_expanded_and_moves_as_pinocchio_says(file, package_dirs):
    robot = ulna.load(file, package_dirs=package_dirs)
    assert robot.n_dof == N_DOF.get(file.name, robot.n_dof)
    peer = Peer(robot, pin.buildModelFromXML(robot.to_urdf(), mimic=True))
    assert farthest_link(peer) < 1e-9
    assert farthest_jacobian(peer) < 1e-9


@pytest.mark.parametrize("file", of_kinds(FILES, CHOSEN_XACROS), ids=lambda file: file.name)
def test_the_torques_of_a_robot_are_those_of_pinocchio(file, package_dirs):
    robot = ulna.load(file, package_dirs=package_dirs)
    if not any(link.inertia for link in robot.description.links if len(robot.tree.moving_columns(link.name))):
        with pytest.raises(ulna.InertiaError):
            robot.gravity_torque(robot.home)
        return
    robot = with_all_inertias(robot)
    worst = differences(Peer(robot, pin.buildModelFromXML(robot.to_urdf())))
    assert max(worst.values()) < 1e-10, worst


@pytest.mark.parametrize("name", BROKEN)
def test_one_that_cannot_be_loaded_is_refused_with_its_reason(name, package_dirs):
    (file,) = (file for file in rtb_xacros() if file.name == name)
    with pytest.raises(DescriptionError, match=BROKEN[name]):
        ulna.load(file, package_dirs=package_dirs)


def test_the_iiwa_that_is_measured_has_its_meshes():
    assert len(load_arm("iiwa14").with_convex_hulls().collision_names) == 8
