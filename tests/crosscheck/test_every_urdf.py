"""Every URDF of example-robot-data against Pinocchio: poses of all links, Jacobians of all tips, in every frame.

Pinocchio is built with its mimic option, but for the robots that defeat it: there it has an entry of q for every joint of the
file, and the peer makes mimics follow. Those are also held against the slow twin.
"""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import formulas
import ulna
from pinocchio_peer import Peer, farthest_jacobian, farthest_link, random_positions
from robot_files import DEFEAT_THE_MIMIC_OPTION, EXAMPLES, URDFS, example_urdfs, installed, of_kinds
from ulna import DescriptionError

NOT_LOADED = {
    "alex_psyonic_hands": r"alex_psyonic_hands\.urdf:1030: joint 'Left_index_q2' mimics 'index_q1', which is not defined; "
    r"did you mean 'Left_index_q1'\?$",
    "ur3": r"ur3\.urdf: the robot has no links$",
}
FILES = example_urdfs()
# Degrees of freedom of some that are well known: an arm of 6 or 7 joints and its gripper, a hand of 16.
N_DOF = {"ur5_robot": 6, "xarm7": 7, "panda": 8, "baxter": 17, "z1": 7, "so101": 6, "allegro_left_hand": 16, "talos_reduced": 32}


def name_of(file: Path) -> str:
    return file.stem


@pytest.fixture(scope="module", params=of_kinds([f for f in FILES if f.stem not in NOT_LOADED]), ids=name_of)
def peer(request):
    robot = ulna.load(request.param)
    return Peer(robot, pin.buildModelFromUrdf(str(request.param), mimic=request.param.stem not in DEFEAT_THE_MIMIC_OPTION))


def test_there_are_as_many_files_as_the_package_had_when_this_was_written():
    assert len(FILES) == 69
    assert {file for file in FILES if not file.is_file()} == set()
    assert {file.stem for file in FILES} >= {*NOT_LOADED, *DEFEAT_THE_MIMIC_OPTION, *N_DOF}


def test_one_that_a_newer_version_of_the_package_adds_can_be_loaded():
    for name in installed(EXAMPLES, ".urdf") - set(URDFS.split()):
        assert ulna.load(EXAMPLES / name).link_names, name


def test_every_link_is_where_pinocchio_puts_it(peer):
    assert farthest_link(peer) < 1e-9


def test_every_tip_moves_as_pinocchio_says_in_every_frame(peer):
    assert farthest_jacobian(peer) < 1e-9


def test_q_has_the_entries_that_pinocchio_has(peer):
    assert peer.model.nv == peer.robot.n_dof + (
        len(peer.mimics) if Path(peer.robot.description.source).stem in DEFEAT_THE_MIMIC_OPTION else 0
    )


@pytest.mark.parametrize("name", N_DOF)
def test_a_robot_has_as_many_degrees_of_freedom_as_it_should(name):
    (file,) = (file for file in FILES if file.stem == name)
    assert ulna.load(file).n_dof == N_DOF[name]


@pytest.mark.parametrize("name", sorted(DEFEAT_THE_MIMIC_OPTION))
def test_what_defeats_pinocchio_is_as_the_slow_twin_has_it(name):
    (file,) = (file for file in FILES if file.stem == name)
    with pytest.raises(ValueError, match="mimic"):
        pin.buildModelFromUrdf(str(file), mimic=True)
    robot = ulna.load(file)
    q = random_positions(robot, 20)
    expected = [formulas.link_poses(robot.description, row) for row in q]
    np.testing.assert_allclose(robot.link_poses(q), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", NOT_LOADED)
def test_a_file_that_cannot_be_loaded_is_refused_with_its_reason(name):
    (file,) = (file for file in FILES if file.stem == name)
    with pytest.raises(DescriptionError, match=NOT_LOADED[name]):
        ulna.load(file)
