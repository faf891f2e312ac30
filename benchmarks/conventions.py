"""What docs/conventions.md says of Robotics Toolbox and of MuJoCo is so: ``.venv-bench/bin/python -m benchmarks.conventions``.

They are not among the packages of the tests. What it says of Pinocchio and Coal is in tests/crosscheck/test_names_of_others.py.
"""

import warnings

import mujoco
import numpy as np

import ulna
from ulna.description.pose import matrix_from_quaternion

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import roboticstoolbox as rtb
    import spatialgeometry
    from spatialmath import SE3, UnitQuaternion

RPY = np.array([0.3, -0.4, 0.9])
MODEL = """<mujoco><worldbody>
  <body name="free" pos="0.1 0.2 0.3" euler="17 -23 51"><freejoint/>
    <geom name="box" type="box" size="0.1 0.2 0.3" mass="1"/></body>
  <body name="arm" pos="2 0 0"><joint type="hinge" axis="0 0 1"/><geom name="capsule" type="capsule" size="0.1 0.4" mass="1"/>
    <geom name="cylinder" type="cylinder" size="0.1 0.4" mass="1"/>
    <body name="hand" pos="0.5 0 0"><geom type="sphere" size="0.1" mass="1"/></body></body>
  <geom name="a" type="sphere" size="0.1" pos="-2 0 0"/>
  <body name="ball" pos="-1.85 0 0"><freejoint/><geom name="b" type="sphere" size="0.1" mass="1"/></body>
</worldbody></mujoco>"""


def toolbox() -> None:
    """Robotics Toolbox: angles, quaternions, rows of tables, frames of Jacobians."""
    same(SE3.RPY(*RPY).R, ulna.pose(rpy=RPY)[:3, :3])
    same(matrix_from_quaternion(UnitQuaternion.RPY(*RPY).vec), ulna.pose(rpy=RPY)[:3, :3])
    standard = rtb.RevoluteDH(a=0.1, d=0.2, alpha=0.3, offset=0.4).A(0.5).A
    same(standard, ulna.pose((0, 0, 0.2), (0, 0, 0.9)) @ ulna.pose((0.1, 0, 0), (0.3, 0, 0)))
    modified = rtb.RevoluteMDH(a=0.1, d=0.2, alpha=0.3, offset=0.4).A(0.5).A
    same(modified, ulna.pose((0.1, 0, 0), (0.3, 0, 0)) @ ulna.pose((0, 0, 0.2), (0, 0, 0.9)))
    theirs = rtb.models.DH.Panda()
    ours = ulna.Robot.from_dh([(link.a, link.d, link.alpha, link.offset) for link in theirs.links], T_n_tip=theirs.tool.A)
    q = np.array([0.1, -0.5, 0.2, -1.8, 0.3, 1.4, 0.6])
    same(theirs.fkine(q).A, ours.forward_kinematics(q))
    same(theirs.jacob0(q), ours.jacobian(q))
    same(theirs.jacobe(q), ours.jacobian(q, expressed_in="link"))
    same(theirs.jacob0_analytical(q, representation="rpy/zyx"), ours.analytical_jacobian(q))
    ball = spatialgeometry.Sphere(0.1, pose=SE3(1, 0, 1))
    same(spatialgeometry.Cuboid([0.2, 0.4, 2.0]).closest_point(ball)[0], 1 - 0.2 / 2 - 0.1)
    same(spatialgeometry.Cylinder(0.3, 2.0).closest_point(ball)[0], 1 - 0.3 - 0.1)  # the ball stands at its edge


def mujoco_itself() -> None:
    """MuJoCo: quaternions, Euler angles, half sizes, frames and order of velocities, distances and normals."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    data.qvel[:7] = np.arange(1, 8) / 10
    mujoco.mj_forward(model, data)
    free = data.body("free")
    R = free.xmat.reshape(3, 3)
    x, y, z = (ulna.pose(rpy=angle * axis)[:3, :3] for angle, axis in zip(np.radians([17, -23, 51]), np.eye(3), strict=True))
    same(R, x @ y @ z)
    same(data.qpos[:7], [0.1, 0.2, 0.3, *free.xquat])
    same(matrix_from_quaternion(free.xquat), R)
    same(model.geom("box").size, [0.1, 0.2, 0.3])
    same(model.geom("capsule").rbound, 0.1 + 0.4)
    same(model.geom("cylinder").rbound, np.hypot(0.1, 0.4))
    velocity = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, model.body("free").id, velocity, 0)
    same(velocity, [*(R @ data.qvel[3:6]), *data.qvel[:3]])
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jacBody(model, data, linear, angular, model.body("hand").id)
    same([linear[:, 6], angular[:, 6]], [[0, 0.5, 0], [0, 0, 1]])
    (contact,) = data.contact
    same([contact.dist, *contact.frame[:3]], [-0.05, 1, 0, 0])
    same(contact.geom, [model.geom("a").id, model.geom("b").id])


def same(a, b) -> None:
    """Fail unless all numbers agree."""
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)


if __name__ == "__main__":
    toolbox()
    mujoco_itself()
    print("what docs/conventions.md says of Robotics Toolbox and MuJoCo is so")
