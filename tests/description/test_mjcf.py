"""Models of MuJoCo, against MuJoCo's own poses of bodies and shapes, and its limits."""

import numpy as np
import pytest

import ulna
from ulna import Box, Capsule, ConvexMesh, Cylinder, DescriptionError, DescriptionWarning, Sphere
from ulna.description import mjcf
from ulna.description.robot_description import JointType

mujoco = pytest.importorskip("mujoco")
from mujoco_peer import Peer, farthest  # noqa: E402 - it needs MuJoCo

ARM = """<mujoco model="arm"><compiler angle="degree"/>
<default><joint armature="0.1"/><default class="seen"><geom contype="0" conaffinity="0"/></default></default>
<worldbody>
  <body name="base" pos="0.1 0 0.2" euler="10 20 30">
    <geom name="foot" type="cylinder" size="0.1 0.05" pos="0 0 0.05"/>
    <body name="upper" pos="0 0 0.1" quat="0.7 0.1 0.2 0.3">
      <joint name="shoulder" type="hinge" axis="0 1 1" pos="0.05 0 0.02" range="-90 60"/>
      <joint name="lift" type="slide" axis="1 0 0" range="-0.1 0.3" ref="0.05"/>
      <geom name="bone" type="capsule" fromto="0 0 0 0.3 0.1 0" size="0.03"/>
      <geom class="seen" type="sphere" size="0.05"/>
      <body name="hand" pos="0.3 0.1 0">
        <joint name="wrist" type="hinge" axis="0 0 1" ref="30" actuatorfrcrange="-8 8"/>
        <geom name="palm" type="box" size="0.04 0.03 0.02" euler="0 45 0"/>
        <geom name="wedge" type="mesh" mesh="wedge"/>
        <body name="left"><joint name="grip" type="slide" axis="0 1 0" range="0 0.04"/><geom type="sphere" size="0.01"/></body>
        <body name="right"><joint name="grip_too" type="slide" axis="0 -1 0" range="0 0.04"/><geom size="0.01"/></body>
      </body>
    </body>
  </body>
</worldbody>
<asset><mesh name="wedge" vertex="0 0 0 0.1 0 0 0 0.1 0 0 0 0.1 0.05 0.05 0.08"/></asset>
<equality><joint name="fingers" joint1="grip_too" joint2="grip" polycoef="0.001 0.9 0 0 0"/></equality>
MORE</mujoco>"""
LIMIT = 1e-12


def text(more="", old="", new=""):
    return ARM.replace("MORE", more).replace(old, new) if old else ARM.replace("MORE", more)


def test_every_body_and_shape_is_where_mujoco_has_it(tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(text())
    robot, model = ulna.load(file), mujoco.MjModel.from_xml_path(str(file))
    assert robot.joint_names == ("shoulder", "lift", "wrist", "grip")
    assert farthest(robot, model, 50) < LIMIT
    assert not Peer(robot, model).others()


def test_limits_types_and_efforts_are_mujocos():
    robot, model = ulna.load(text()), mujoco.MjModel.from_xml_string(text())
    joints = {joint.name: joint for joint in robot.description.joints}
    for k in range(model.njnt):
        joint = joints[mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k)]
        limits = (joint.limits.lower, joint.limits.upper)
        assert limits == (tuple(model.jnt_range[k]) if model.jnt_limited[k] else (-np.inf, np.inf))
    assert (joints["wrist"].type, joints["shoulder"].type) == (JointType.CONTINUOUS, JointType.REVOLUTE)
    assert joints["wrist"].limits.effort == 8.0
    assert (joints["grip_too"].mimic.joint, joints["grip_too"].mimic.multiplier) == ("grip", 0.9)


def test_shapes_are_whole_where_mujoco_has_halves_and_what_touches_nothing_is_only_seen():
    links = {link.name: link for link in ulna.load(text()).description.links}
    assert links["base"].collisions[0].shape == Cylinder(0.1, 0.1)
    assert links["upper"].visuals[0].shape == Sphere(0.05)
    (bone,) = links["upper"].collisions
    assert isinstance(bone.shape, Capsule)
    assert bone.shape.length == pytest.approx(np.hypot(0.3, 0.1))
    box, wedge = (body.shape for body in links["hand"].collisions)
    assert box == Box((0.08, 0.06, 0.04))
    assert isinstance(wedge, ConvexMesh)


def test_it_plans_and_compares_and_is_inspected(tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(text())
    robot = ulna.load(file)
    assert ulna.compare(robot, ulna.load(text())).same
    assert not ulna.compare(robot, ulna.load(text(old='range="-90 60"', new='range="-90 50"'))).same
    found = ulna.inspect(file)
    assert (found.loads, found.n_dof) == (True, 4)
    assert isinstance(robot.in_collision(robot.home), bool)


REFUSED = {
    "a ball joint": (
        text(old='type="hinge" axis="0 1 1" pos="0.05 0 0.02" range="-90 60"', new='type="ball"'),
        "joint 'shoulder' is a ball",
    ),
    "a weld": (text('<equality><weld name="w" body1="left" body2="upper"/></equality>'), "equality 'w' closes a loop"),
    "a connection": (
        text('<equality><connect name="c" body1="left" body2="upper" anchor="0 0 0"/></equality>'),
        "equality 'c' closes",
    ),
    "a curve": (text(old="0.001 0.9 0 0 0", new="0 1 0.5 0 0"), "equality 'fingers' of joints is not linear"),
    "a tendon with a limit": (
        text('<tendon><fixed name="cord" limited="true" range="0 1"><joint joint="lift" coef="1"/></fixed></tendon>'),
        "tendon 'cord' couples joints",
    ),
    "what MuJoCo refuses": (text(old='size="0.1 0.05"', new=""), "MuJoCo: "),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_tree_of_joints_is_refused_by_its_name(name):
    document, words = REFUSED[name]
    with pytest.raises(DescriptionError, match=words):
        ulna.load(document)


def test_a_floor_of_the_world_is_left_out_with_a_warning():
    document = text(old="<worldbody>", new='<worldbody><geom name="floor" type="plane" size="1 1 1"/>')
    with pytest.warns(DescriptionWarning, match=r"link 'world': geom 'floor' is a plane, which is not supported: it is left out"):
        assert ulna.load(document).n_dof == 4


HOSTILE = {
    "a texture of 30 GB": "<asset><texture name='t' type='2d' builtin='flat' width='100000' height='100000'/></asset>",
    "a field of heights of 40 GB": "<asset><hfield name='h' nrow='100000' ncol='100000' size='1 1 1 1'/></asset>",
    "an arena of 900 GB": "<size memory='900G'/>",
    "copies without end": "<worldbody><replicate count='1000000000' offset='1 0 0'><geom size='1'/></replicate></worldbody>",
}


@pytest.mark.process
@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_model_is_refused_by_a_named_error_in_time(name, monkeypatch):
    monkeypatch.setattr(mjcf, "TIME_LIMIT_S", 5.0)
    with pytest.raises(DescriptionError, match="MuJoCo: "):
        ulna.load(f"<mujoco>{HOSTILE[name]}</mujoco>")
