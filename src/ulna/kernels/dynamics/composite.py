"""Computes the mass matrix by the composite rigid body algorithm, and the center of mass, in the base frame.

Source: Walker and Orin, Efficient dynamic computer simulation of robotic mechanisms (J. Dynamic Systems, Measurement and
Control 1982); Featherstone, Rigid Body Dynamics Algorithms (2008), section 6.2.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, store
from ulna.kernels.chain.jacobian import clear, joint_twist
from ulna.kernels.chain.poses import turned_joint_pose
from ulna.kernels.dynamics.rigid_body import (
    add_inertias,
    body_inertia,
    load_inertia,
    load_pair,
    momentum,
    pair_dot,
    store_inertia,
    store_pair,
    to_parent_frame,
)
from ulna.kernels.layout import COLUMN, INERTIA_WIDTH, KIND, MASS, MOMENT, PARENT, PRISMATIC, RATIO
from ulna.kernels.spatial.se3 import compose, load_pose, store_pose
from ulna.kernels.spatial.vectors import add_scaled, cross, load_vector, minus, origin, plus, rotate, scaled, store_vector, z_axis


@kernel
def pose_bodies(mechanism, turn_rows, rows):
    """Write the pose, the twist and the inertia of each joint's own body to ``BodyRows``."""
    joints = mechanism.joints
    for i in range(joints.shape[0]):
        pose = pose_joint(joints, i, turn_rows, rows.poses)
        v, w = joint_twist(joints, i, pose)
        store_pair(rows.twists, i, v, w)
        store_inertia(rows.inertias, i, to_parent_frame(pose, body_inertia(mechanism.bodies, i, pose[0])))


@kernel
def pose_joint(joints, i, turn_rows, pose_rows):
    """Write and return the pose of joint i in the base; the poses of its ancestors are already written."""
    pose, parent = turned_joint_pose(joints, i, turn_rows), int(joints[i, PARENT])
    if parent >= 0:
        pose = compose(load_pose(pose_rows, parent), pose)
    store_pose(pose_rows, i, pose)
    return pose


@kernel
def gather_inertias(joints, inertia_rows):
    """Add the inertias of all descendant bodies to the inertia of each joint's body."""
    for k in range(joints.shape[0] - 1):
        i = joints.shape[0] - 1 - k
        parent = int(joints[i, PARENT])
        if parent >= 0:
            store_inertia(inertia_rows, parent, add_inertias(load_inertia(inertia_rows, parent), load_inertia(inertia_rows, i)))


@kernel
def mass_matrix(mechanism, turn_rows, n_dof, rows, mass_rows):
    """Write the mass matrix M, with entry (r, c) in row n_dof * r + c of ``mass_rows``.

    1. Compute the composite inertia of each joint's subtree, in the frame of the base.
    2. Compute the momentum of joint i's subtree for a unit rate of its entry of q. Each joint j between it and the base adds
       S_j . (I_i S_i) to the matrix, where S is a twist. Joints of one entry of q, such as mimic joints, add up.
    """
    joints = mechanism.joints
    pose_bodies(mechanism, turn_rows, rows)
    gather_inertias(joints, rows.inertias)
    clear(mass_rows, load(turn_rows, 0))
    for i in range(joints.shape[0]):
        v, w = load_pair(rows.twists, i)
        carried = momentum(load_inertia(rows.inertias, i), v, w)
        column, j = int(joints[i, COLUMN]), i
        while j >= 0:
            entry, row = pair_dot(load_pair(rows.twists, j), carried), int(joints[j, COLUMN])
            add_to(mass_rows, n_dof * row + column, entry)
            if j != i:
                add_to(mass_rows, n_dof * column + row, entry)
            j = int(joints[j, PARENT])


@kernel
def add_to(rows, k, x):
    """Add a number to row k."""
    store(rows, k, load(rows, k) + x)


@kernel
def moment_columns(mechanism, turn_rows, rows, columns):
    """Write the derivative of the first moment (mass times center of mass) of all moving bodies with respect to q.

    1. Compute the mass m and the moment h of each joint's subtree, in the frame of the base.
    2. A prismatic joint moves the mass along its axis z: m z. A revolute joint turns the moment about its origin p:
       z x (h - m p).

    Args:
        mechanism: The robot.
        turn_rows: The output of ``joint_turns``.
        rows: ``BodyRows``; only masses and moments of the inertias are used.
        columns: Three rows for each entry of q.

    Returns:
        The mass [kg] and the moment [kg m] of all moving bodies.
    """
    joints, like = mechanism.joints, load(turn_rows, 0)
    for i in range(joints.shape[0]):
        pose, mass = pose_joint(joints, i, turn_rows, rows.poses), mechanism.bodies[i, MASS]
        store(rows.inertias, INERTIA_WIDTH * i, splat(mass, like))
        store_vector(
            rows.inertias, INERTIA_WIDTH * i + 1, add_scaled(rotate(pose, first_moment(mechanism.bodies, i)), mass, origin(pose))
        )
    clear(columns, like)
    all_mass, zero = splat(0.0, like), splat(0.0, like)
    all_moment = zero, zero, zero
    for k in range(joints.shape[0]):
        i = joints.shape[0] - 1 - k
        place, parent, column = INERTIA_WIDTH * i, int(joints[i, PARENT]), 3 * int(joints[i, COLUMN])
        mass, moment = load(rows.inertias, place), load_vector(rows.inertias, place + 1)
        pose = load_pose(rows.poses, i)
        if int(joints[i, KIND]) == PRISMATIC:
            moved = scaled(z_axis(pose), mass)
        else:
            moved = cross(z_axis(pose), minus(moment, scaled(origin(pose), mass)))
        store_vector(columns, column, plus(load_vector(columns, column), scaled(moved, joints[i, RATIO])))
        if parent >= 0:
            place = INERTIA_WIDTH * parent
            add_to(rows.inertias, place, mass)
            store_vector(rows.inertias, place + 1, plus(load_vector(rows.inertias, place + 1), moment))
        else:
            all_mass, all_moment = all_mass + mass, plus(all_moment, moment)
    return all_mass, all_moment


@kernel
def first_moment(bodies, i):
    """The moment of row i of a table of inertias."""
    return bodies[i, MOMENT], bodies[i, MOMENT + 1], bodies[i, MOMENT + 2]
