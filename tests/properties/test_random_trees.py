"""Any tree of joints that a description can say, against the twin that walks its joints: poses, velocities, order of q."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import formulas
import ulna
from assertions import assert_close
from ulna.description.robot_description import Description, Joint, JointType, Link, Mimic

KINDS = list(JointType)
FRAMES = ["base", "link", "spatial"]
AXES = [v / np.linalg.norm(v) for v in np.array(list(np.ndindex(5, 5, 5))) - 2.0 if v.any()]
numbers = st.floats(-1.0, 1.0).map(lambda x: round(x, 4))
vectors = st.tuples(numbers, numbers, numbers)


@st.composite
def descriptions(draw):
    """Up to nine joints, each on any link before it, some of them mimics, listed in any order."""
    joints = []
    for k in range(draw(st.integers(0, 9))):
        kind = draw(st.sampled_from(KINDS))
        followed = [j.name for j in joints if formulas.N_POSITIONS[j.type] == 1]
        mimic = None
        if formulas.N_POSITIONS[kind] == 1 and followed and draw(st.booleans()):
            mimic = Mimic(draw(st.sampled_from(followed)), 2 * draw(numbers), draw(numbers))
        origin = formulas.from_rpy(draw(vectors), 3 * np.array(draw(vectors)))
        axis = np.array([0.0, 0.0, 1.0]) if kind == "floating" else draw(st.sampled_from(AXES))
        joints.append(Joint(f"j{k}", kind, f"l{draw(st.integers(0, k))}", f"l{k + 1}", origin, axis, mimic=mimic))
    links = [Link(f"l{k}") for k in range(len(joints) + 1)]
    return Description("random", tuple(draw(st.permutations(links))), tuple(draw(st.permutations(joints))))


def positions(description, n):
    n_dof = sum(formulas.N_POSITIONS[joint.type] for joint in description.joints if joint.mimic is None)
    return np.random.default_rng(len(description.joints)).uniform(-1.4, 1.4, (n, n_dof))


@settings(max_examples=80)
@given(descriptions())
def test_every_link_is_where_the_twin_puts_it(description):
    robot, q = ulna.Robot(description), positions(description, 9)
    poses = robot.link_poses(q)
    assert_close(poses, [formulas.link_poses(description, x) for x in q], atol=1e-13)
    assert_close(robot.link_poses(q[4]), poses[4], atol=1e-14)
    for k, link in enumerate(robot.link_names):
        assert_close(robot.forward_kinematics(q, link=link), poses[:, k], atol=2e-14)


@settings(max_examples=40)
@given(descriptions(), st.data())
def test_columns_of_the_jacobian_are_the_velocities_of_the_link(description, data):
    robot, q = ulna.Robot(description), positions(description, 2)
    link = data.draw(st.sampled_from(robot.link_names))
    for frame in FRAMES:
        expected = [formulas.jacobian(description, x, link, frame) for x in q]
        assert_close(robot.jacobian(q[0], link=link, expressed_in=frame), expected[0], atol=1e-9)
        if robot.n_dof:
            assert_close(robot.jacobian(q, link=link, expressed_in=frame), expected, atol=1e-9)


@settings(max_examples=40)
@given(descriptions(), st.data())
def test_the_analytical_jacobian_is_the_rate_of_roll_pitch_and_yaw(description, data):
    robot, q = ulna.Robot(description), positions(description, 1)[0]
    link = data.draw(st.sampled_from(robot.link_names))
    R = robot.forward_kinematics(q, link=link)[:3, :3]
    if np.hypot(R[0, 0], R[1, 0]) < 0.1:
        return  # near gimbal lock the rates are large, and differences poor
    Ja = robot.analytical_jacobian(q, link=link)

    def rpy(s, unit):
        R = formulas.link_pose(description, q + s * unit, link)[:3, :3]
        return np.array([np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])])

    at_zero = rpy(0.0, np.zeros(robot.n_dof))
    for j, unit in enumerate(np.eye(robot.n_dof)):

        def turned(s, unit=unit):
            return (rpy(s, unit) - at_zero + np.pi) % (2 * np.pi)  # without jumps at -pi

        assert_close(Ja[3:, j], formulas.derivative(turned, 0.0, 1e-4), atol=1e-6)
        assert_close(Ja[:3, j], robot.jacobian(q, link=link)[:3, j], atol=0)


@settings(max_examples=80)
@given(descriptions())
def test_q_is_in_the_order_of_the_joints_from_the_root_and_files_may_list_them_in_any(description):
    robot = ulna.Robot(description)
    independent = [j for j in formulas.joints_from_root(description) if formulas.N_POSITIONS[j.type] and j.mimic is None]
    assert robot.joint_names == tuple(joint.name for joint in independent)
    assert [s.stop - s.start for s in robot.joint_slices] == [formulas.N_POSITIONS[joint.type] for joint in independent]
    assert [s.start for s in robot.joint_slices] == [0, *(s.stop for s in robot.joint_slices[:-1])][: len(independent)]
    assert robot.link_names == tuple(link.name for link in description.links)
    leaves, moved = {link.name for link in description.links} - {joint.parent for joint in description.joints}, set()
    for joint in formulas.joints_from_root(description):
        if formulas.N_POSITIONS[joint.type] or joint.parent in moved:
            moved.add(joint.child)
    leaves = leaves & moved or leaves
    assert robot.tip == (leaves.pop() if len(leaves) == 1 else None)
