"""MJCF models of a package of the index, against MuJoCo's own compiled models. More are read by benchmarks/mjcf_files.py."""

import sys
from pathlib import Path

import mujoco
import pytest

import ulna
from mujoco_peer import Peer, farthest

FOLDERS = [Path(entry) / "dm_robotics" / "panda" / "assets" / "panda" for entry in sys.path]
FOUND = sorted(file for folder in FOLDERS for file in folder.glob("*.xml"))


@pytest.mark.skipif(not FOUND, reason="no package dm-robotics-panda: make .venv/.dev installs it")
@pytest.mark.parametrize("name", ["panda.xml", "panda_hand.xml"])
def test_a_model_is_where_mujoco_has_it_with_its_limits_and_shapes(name):
    (file,) = (file for file in FOUND if file.name == name)
    robot, model = ulna.load(file), mujoco.MjModel.from_xml_path(str(file))
    assert farthest(robot, model, 50) < 1e-12
    assert not Peer(robot, model).others()
    assert robot.n_dof == model.nq - model.neq  # the second finger follows the first


def test_a_wrong_pose_limit_or_shape_is_seen():
    text = (
        "<mujoco><worldbody><body name='a'><joint name='j' range='-1 1'/><geom name='g' size='0.1'/></body></worldbody></mujoco>"
    )
    robot = ulna.load(text)
    for old, new in (("-1 1", "-1 2"), ("0.1", "0.2"), ("name='g'", "name='g' type='box'")):
        assert Peer(
            robot, mujoco.MjModel.from_xml_string(text.replace(old, new).replace("box' size='0.1'", "box' size='1 1 1'"))
        ).others()
    moved = mujoco.MjModel.from_xml_string(text.replace("<body name='a'", "<body name='a' pos='0 0 1e-6'"))
    assert farthest(robot, moved, 1) > 1e-7
