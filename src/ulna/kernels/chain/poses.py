"""Computes the poses of a joint, of a chain's end and of all joints of a tree.

A joint rotates by an angle, which needs a sine and a cosine, or slides by a length. For eight configurations of a chain, the
values of all joints are computed first, and then the poses. A sine is a long chain of dependent operations. A processor overlaps
the sines of several joints if no products of poses lie between them.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store
from ulna.kernels.layout import AT_JOINT, COLUMN, FIXED, JOINT, KIND, OFFSET, PARENT, PRISMATIC, RATIO, REVOLUTE
from ulna.kernels.spatial.elementary import sincos
from ulna.kernels.spatial.se3 import (
    compose,
    constant_pose,
    load_pose,
    slide_along_z,
    store_pose,
    turn_about_z,
    turned_about_z,
)


@kernel
def joint_value(table, i, q_rows):
    """The angle or length of joint i at the configuration q."""
    return load(q_rows, int(table[i, COLUMN])) * table[i, RATIO] + table[i, OFFSET]


@kernel
def joint_pose(table, i, q_rows):
    """T_parent_joint of row i at the configuration q."""
    kind = int(table[i, KIND])
    origin = constant_pose(table, i, load(q_rows, 0))
    if kind == FIXED:
        return origin
    if kind == PRISMATIC:
        return slide_along_z(origin, joint_value(table, i, q_rows))
    return turn_about_z(origin, joint_value(table, i, q_rows))


@kernel
def chain_pose(chain, q_rows):
    """The pose of a chain's end: T_base_end = T_base_1(q) T_1_2(q) ... T_n_end."""
    pose = joint_pose(chain, 0, q_rows)
    for i in range(1, chain.shape[0]):
        pose = compose(pose, joint_pose(chain, i, q_rows))
    return pose


@kernel
def joint_turns(chain, q_rows, turn_rows):
    """Write the sine and cosine of each revolute joint, and the length of each prismatic one.

    Joint i has the rows ``2 i`` and ``2 i + 1``; a length is in row ``2 i``.

    The values come first, in a loop of their own: the table gives the entry of q of each joint. If a sine had to wait for this
    look-up, the processor could not overlap it with the next joint's sine.
    """
    for i in range(chain.shape[0]):
        if int(chain[i, KIND]) != FIXED:
            store(turn_rows, 2 * i, joint_value(chain, i, q_rows))
    for i in range(chain.shape[0]):
        if int(chain[i, KIND]) == REVOLUTE:
            s, c = sincos(load(turn_rows, 2 * i))
            store(turn_rows, 2 * i, s)
            store(turn_rows, 2 * i + 1, c)


@kernel
def turned_joint_pose(chain, i, turn_rows):
    """``joint_pose`` from the output of ``joint_turns``."""
    kind = int(chain[i, KIND])
    origin = constant_pose(chain, i, load(turn_rows, 0))
    if kind == FIXED:
        return origin
    if kind == PRISMATIC:
        return slide_along_z(origin, load(turn_rows, 2 * i))
    return turned_about_z(origin, load(turn_rows, 2 * i), load(turn_rows, 2 * i + 1))


@kernel
def turned_chain_pose(chain, turn_rows):
    """``chain_pose`` from the output of ``joint_turns``."""
    pose = turned_joint_pose(chain, 0, turn_rows)
    for i in range(1, chain.shape[0]):
        pose = compose(pose, turned_joint_pose(chain, i, turn_rows))
    return pose


@kernel
def tree_poses(joints, q_rows, joint_rows):
    """Write the pose of every joint of the table to joint_rows. Parents come before their children."""
    for i in range(joints.shape[0]):
        pose = joint_pose(joints, i, q_rows)
        parent = int(joints[i, PARENT])
        if parent >= 0:
            pose = compose(load_pose(joint_rows, parent), pose)
        store_pose(joint_rows, i, pose)


@kernel
def frame_pose(frames, k, joint_rows, like):
    """The pose in the base of frame k, which is fixed to its joint."""
    joint = int(frames[k, JOINT])
    if joint < 0:
        return constant_pose(frames, k, like)
    pose = load_pose(joint_rows, joint)
    if frames[k, AT_JOINT] != 0.0:
        return pose
    return compose(pose, constant_pose(frames, k, like))
