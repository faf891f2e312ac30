"""Inertias, damping and friction: read in the axes of the link, written again, and left out where they are faulty."""

import pickle
import warnings

import numpy as np
import pytest

import formulas
import ulna
from ulna import InputError

NUMBERS = 'ixx="0.4" ixy="0.02" ixz="-0.03" iyy="0.5" iyz="0.04" izz="0.6"'
TENSOR = np.array([[0.4, 0.02, -0.03], [0.02, 0.5, 0.04], [-0.03, 0.04, 0.6]])
XYZ, RPY = (0.1, -0.2, 0.3), (0.3, -0.5, 1.2)
INERTIAL = f'<inertial><origin xyz="0.1 -0.2 0.3" rpy="0.3 -0.5 1.2"/><mass value="2.5"/><inertia {NUMBERS}/></inertial>'
ARM = """<robot name="arm"><link name="base"/><link name="arm">INERTIAL</link><link name="tip"/>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/>DYNAMICS</joint>
<joint name="end" type="fixed"><parent link="arm"/><child link="tip"/></joint></robot>"""


def text(inertial=INERTIAL, dynamics=""):
    return ARM.replace("INERTIAL", inertial).replace("DYNAMICS", dynamics)


def of(robot, name="arm"):
    return next(link.inertia for link in robot.description.links if link.name == name)


def turned():
    R = formulas.from_rpy(XYZ, RPY)[:3, :3]
    return R @ TENSOR @ R.T


def equal(a, b):
    assert a.mass == b.mass
    np.testing.assert_array_equal(a.center, b.center)
    np.testing.assert_array_equal(a.tensor, b.tensor)


def test_a_tensor_is_turned_into_the_axes_of_the_link():
    inertia = of(ulna.load(text()))
    assert inertia.mass == 2.5
    np.testing.assert_array_equal(inertia.center, XYZ)
    np.testing.assert_allclose(inertia.tensor, turned(), rtol=0, atol=1e-16)
    assert not np.allclose(inertia.tensor, TENSOR, atol=1e-2)


def test_a_link_without_one_has_none_and_a_mass_of_0_is_read_as_it_is():
    none = INERTIAL.replace("2.5", "0").replace(NUMBERS, 'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"')
    robot = ulna.load(text(none))
    assert of(robot, "base") is None
    assert (of(robot).mass, of(robot).tensor.any()) == (0.0, False)


FAULTY = {
    "a mass that is not a number": INERTIAL.replace('"2.5"', '"heavy"'),
    "a mass that is not finite": INERTIAL.replace('"2.5"', '"inf"'),
    "a negative mass": INERTIAL.replace('"2.5"', '"-2.5"'),
    "a mass without a value": INERTIAL.replace(' value="2.5"', ""),
    "no mass": INERTIAL.replace('<mass value="2.5"/>', ""),
    "no tensor": INERTIAL.replace(f"<inertia {NUMBERS}/>", ""),
    "a missing moment": INERTIAL.replace(' iyz="0.04"', ""),
    "a moment that is not finite": INERTIAL.replace('"0.6"', '"nan"'),
    "a moment beyond all numbers": INERTIAL.replace('"0.6"', '"1e308"'),
    "an origin of two numbers": INERTIAL.replace("0.1 -0.2 0.3", "0.1 -0.2"),
    "two inertias": INERTIAL * 2,
}


@pytest.mark.parametrize("name", FAULTY)
def test_a_faulty_one_is_left_out_and_the_robot_loads(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = ulna.load(text(FAULTY[name]))
    assert of(robot) is None
    (part,) = robot.description.left_out
    assert (part.where, part.line) == ("link 'arm'", 1)
    assert part.message.endswith("this inertia is left out, so it has none")
    assert [one for one in ulna.inspect(text(FAULTY[name])).findings if one.message == part.message]
    np.testing.assert_array_equal(robot.forward_kinematics([0.3]), ulna.load(text()).forward_kinematics([0.3]))


def test_damping_and_friction_are_read_and_faulty_ones_are_0():
    joint, end = ulna.load(text(dynamics='<dynamics damping="0.7" friction="0.2"/>')).description.joints
    assert (joint.damping, joint.friction, end.damping) == (0.7, 0.2, 0.0)
    robot = ulna.load(text(dynamics='<dynamics damping="-1" friction="0.2"/>'))
    assert (robot.description.joints[0].damping, robot.description.joints[0].friction) == (0.0, 0.2)
    assert [part.where for part in robot.description.left_out] == ["joint 'j'"]


def test_what_is_written_is_read_again_as_it_was():
    robot = ulna.load(text(dynamics='<dynamics damping="0.7" friction="0.2"/>')).with_limits(upper=0.5)
    again = ulna.load(robot.to_urdf())
    assert robot.to_urdf() != robot.description.text
    equal(of(again), of(robot))
    assert (again.description.joints[0].damping, again.description.joints[0].friction) == (0.7, 0.2)
    assert of(again, "base") is None


def test_a_part_of_a_robot_a_pickle_and_hulls_keep_the_inertias():
    robot = ulna.load("ur5")
    expected = {link.name: link.inertia for link in robot.description.links}
    kept = [
        pickle.loads(pickle.dumps(robot)),  # noqa: S301 - our own
        robot.with_convex_hulls(),
        ulna.load("ur5", base="shoulder_link", tip="wrist_2_link"),
    ]
    for part in kept:
        assert len(part.link_names) > 3
        for link in part.description.links:
            if expected[link.name] is None:
                assert link.inertia is None
            else:
                equal(link.inertia, expected[link.name])


def test_a_xacro_gives_those_that_it_computes(tmp_path):
    body = text(INERTIAL.replace('"2.5"', '"${5 / 2}"')).replace("<robot", '<robot xmlns:xacro="http://ros.org/wiki/xacro"')
    (tmp_path / "arm.urdf.xacro").write_text(body)
    equal(of(ulna.load(tmp_path / "arm.urdf.xacro")), of(ulna.load(text())))


MODEL = """<mujoco model="arm"><compiler angle="radian"/><worldbody><body name="base" pos="0.1 0 0.2"><geom size="0.1"/>
<body name="arm" pos="0 0 0.1" quat="0.7 0.1 0.2 0.3">
<joint name="a" type="hinge" axis="0 1 1" pos="0.05 0 0.02" range="-1 1" damping="0.7" frictionloss="0.2" armature="0.1"/>
<joint name="b" type="slide" axis="1 0 0" range="-0.1 0.3" ref="0.05"/>
<geom type="capsule" fromto="0 0 0 0.3 0.1 0" size="0.03"/><geom type="box" size="0.1 0.02 0.05" pos="0.1 0.2 0.3"/>
<body name="hand" pos="0.3 0.1 0"><inertial pos="0.1 -0.2 0.3" mass="2.5" fullinertia="0.4 0.5 0.6 0.02 -0.03 0.04"/>
<joint name="c" axis="0 0 1" range="-1 1"/><geom size="0.01"/><body name="frame"/></body></body></body></worldbody></mujoco>"""


def test_the_inertia_of_a_body_is_mujocos_in_the_world():
    mujoco = pytest.importorskip("mujoco")
    robot, model = ulna.load(MODEL), mujoco.MjModel.from_xml_string(MODEL)
    for q in robot.random(20, seed=1):
        data = mujoco.MjData(model)
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        poses = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
        for k in range(1, model.nbody):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, k)
            ours, T, R = of(robot, name), poses[name], data.ximat[k].reshape(3, 3)
            if name == "frame":
                assert ours is None
                continue
            assert ours.mass == model.body_mass[k]
            np.testing.assert_allclose(T[:3, :3] @ ours.center + T[:3, 3], data.xipos[k], rtol=0, atol=1e-12)
            tensor = T[:3, :3] @ ours.tensor @ T[:3, :3].T
            np.testing.assert_allclose(tensor, R @ np.diag(model.body_inertia[k]) @ R.T, rtol=0, atol=1e-12)
    np.testing.assert_allclose(of(robot, "hand").tensor, TENSOR, rtol=0, atol=1e-12)
    a, *_ = (joint for joint in robot.description.joints if joint.name == "a")
    assert (a.damping, a.friction) == (0.7, 0.2)
    notes = [finding.message for finding in ulna.inspect(MODEL).findings]
    assert "armature, the inertia of rotors, is not read: no torque includes it" in notes
    assert "damping and friction are read and written, but no torque includes them" in notes


SDF = """<sdf version="1.9"><model name="arm"><link name="base"/><link name="arm"><pose>0 0 1 0 0 0.4</pose>INERTIAL</link>
<joint name="j" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz>
<dynamics><damping>0.7</damping><friction>0.2</friction><spring_stiffness>0</spring_stiffness></dynamics></axis></joint></model></sdf>"""
OF_SDF = (
    "<inertial><pose>0.1 -0.2 0.3 0.3 -0.5 1.2</pose><mass>2.5</mass><inertia><ixx>0.4</ixx><ixy>0.02</ixy><ixz>-0.03</ixz>"
    "<iyy>0.5</iyy><iyz>0.04</iyz><izz>0.6</izz></inertia></inertial>"
)


def test_sdf_gives_what_urdf_does():
    robot = ulna.load(SDF.replace("INERTIAL", OF_SDF))
    equal(of(robot), of(ulna.load(text())))
    (joint,) = (joint for joint in robot.description.joints if joint.name == "j")
    assert (joint.damping, joint.friction) == (0.7, 0.2)
    assert of(robot, "base") is None


def test_sdf_has_a_mass_of_1_and_moments_of_1_where_it_states_none():
    inertia = of(ulna.load(SDF.replace("INERTIAL", "<inertial/>")))
    assert inertia.mass == 1.0
    np.testing.assert_array_equal(inertia.tensor, np.eye(3))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<mass>2.5</mass>", "<mass>-2.5</mass>", "at least 0 expected"),
        ("<izz>0.6</izz>", "<izz>nan</izz>", "finite number expected"),
        ("<inertial>", '<inertial auto="true">', "auto, an inertia computed from shapes"),
        ("<pose>0.1", '<pose relative_to="base">0.1', "relative_to"),
    ],
)
def test_a_faulty_one_of_sdf_is_left_out(old, new, words):
    robot = ulna.load(SDF.replace("INERTIAL", OF_SDF.replace(old, new)))
    assert of(robot) is None
    assert any(words in part.message and "this inertia is left out" in part.message for part in robot.description.left_out)


def test_a_tool_has_the_mass_that_is_given_and_is_written_with_it():
    robot = ulna.load(text())
    tool = robot.with_tool(ulna.pose((0, 0, 0.2)), mass=0.5, com=(0.01, 0, 0.03), inertia=np.diag([3e-3, 2e-3, 2e-3]))
    pickled = pickle.loads(pickle.dumps(tool))  # noqa: S301 - our own
    for one in (tool, ulna.load(tool.to_urdf()), pickled):
        inertia = of(one, "tool")
        assert inertia.mass == 0.5
        np.testing.assert_array_equal(inertia.center, (0.01, 0, 0.03))
        np.testing.assert_array_equal(inertia.tensor, np.diag([3e-3, 2e-3, 2e-3]))
    equal(of(tool), of(robot))
    assert of(robot.with_tool(np.eye(4)), "tool") is None
    point = of(robot.with_tool(np.eye(4), mass=0.5), "tool")
    assert (point.mass, point.center.any(), point.tensor.any()) == (0.5, False, False)


@pytest.mark.parametrize(
    ("given", "argument"),
    [
        ({"mass": -1.0}, "mass"),
        ({"mass": np.nan}, "mass"),
        ({"mass": "1"}, "mass"),
        ({"com": (0, 0, 0)}, "com"),
        ({"inertia": np.eye(3)}, "inertia"),
        ({"mass": 1.0, "com": (0, 0)}, "com"),
        ({"mass": 1.0, "com": (0, 0, np.inf)}, "com"),
        ({"mass": 1.0, "inertia": np.eye(2)}, "inertia"),
        ({"mass": 1.0, "inertia": np.diag([1, 1, -1])}, "inertia"),
        ({"mass": 1.0, "inertia": np.diag([1, 1, 3])}, "inertia"),
        ({"mass": 1.0, "inertia": np.triu(np.ones((3, 3))) + 5 * np.eye(3)}, "inertia"),
        ({"mass": 0.0, "inertia": np.eye(3)}, "inertia"),
    ],
)
def test_what_no_body_has_is_refused(given, argument):
    with pytest.raises(InputError) as refused:
        ulna.load(text()).with_tool(np.eye(4), **given)
    assert refused.value.argument == argument
