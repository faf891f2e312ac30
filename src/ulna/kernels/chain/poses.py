"""Computes the pose of a joint, of a chain's end and of all joints of a tree.

A joint turns by an angle, whose sine and cosine are needed, or slides by a length. For eight configurations of a chain these are
computed for all joints first, and then the poses. A sine is a long chain of operations, each of which waits for the one before; a
processor begins the next joint's meanwhile if they are next to each other, with no products of poses between them.
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
    """By how much joint i turns or slides at the configuration q."""
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
    """Write, for joint i, the sine and the cosine of its angle to rows 2 i and 2 i + 1; a length that it slides to row 2 i.

    The values come first, in a loop of their own: which entry of q moves a joint is read from the table. If a sine had to
    wait for that, the processor could not begin the next joint's sine meanwhile.
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
    """``joint_pose`` by what ``joint_turns`` wrote."""
    kind = int(chain[i, KIND])
    origin = constant_pose(chain, i, load(turn_rows, 0))
    if kind == FIXED:
        return origin
    if kind == PRISMATIC:
        return slide_along_z(origin, load(turn_rows, 2 * i))
    return turned_about_z(origin, load(turn_rows, 2 * i), load(turn_rows, 2 * i + 1))


@kernel
def turned_chain_pose(chain, turn_rows):
    """``chain_pose`` by what ``joint_turns`` wrote."""
    pose = turned_joint_pose(chain, 0, turn_rows)
    for i in range(1, chain.shape[0]):
        pose = compose(pose, turned_joint_pose(chain, i, turn_rows))
    return pose


@kernel
def tree_poses(joints, q_rows, joint_rows):
    """Write the pose of every joint of the table (parents come before their children) to joint_rows."""
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
