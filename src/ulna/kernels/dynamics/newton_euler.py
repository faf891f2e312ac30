"""Computes the torques of a motion by the recursive Newton-Euler algorithm, each body in the frame of its joint.

Source: Luh, Walker and Paul, On-line computational scheme for mechanical manipulators (J. Dynamic Systems, Measurement and
Control 1980); Featherstone, Rigid Body Dynamics Algorithms (2008), table 5.1.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, store
from ulna.kernels.chain.poses import turned_joint_pose
from ulna.kernels.dynamics.dynamics_records import MOTION_WIDTH
from ulna.kernels.dynamics.rigid_body import (
    add_pair,
    body_inertia,
    load_pair,
    store_pair,
    symmetric_times,
)
from ulna.kernels.layout import COLUMN, KIND, PARENT, PRISMATIC, RATIO
from ulna.kernels.spatial.se3 import load_pose, store_pose
from ulna.kernels.spatial.vectors import cross, load_vector, origin, plus, rotate, rotate_inverse, scaled, store_vector


@kernel
def newton_euler(mechanism, gravity, state, rows, torque_rows):
    """Write the torques [Nm or N] of all entries of q to torque_rows.

    1. From the base to the tips: compute the angular velocity and acceleration of each joint's frame, and the acceleration of
       its origin. The base accelerates by -g, which has the effect of gravity.
    2. Compute the wrench that each body needs, by the laws of Newton and Euler.
    3. From the tips to the base: a joint carries the wrenches of its subtree. Its torque is the component along its axis.

    Args:
        mechanism: The table of joints and the table of inertias, one row per joint.
        gravity: The gravitational acceleration [m/s^2] in the axes of the base: three plain numbers.
        state: ``State``: the output of ``joint_turns``, and the rates and accelerations of q.
        rows: ``ForceRows`` as workspace.
        torque_rows: One row for each entry of q.
    """
    joints = mechanism.joints
    base_motion(gravity, state, rows)
    for i in range(joints.shape[0]):
        move(mechanism, i, state, rows)
    for k in range(torque_rows.shape[0]):
        store(torque_rows, k, splat(0.0, load(torque_rows, k)))
    for k in range(joints.shape[0]):
        carry(joints, joints.shape[0] - 1 - k, rows, torque_rows)


@kernel
def base_motion(gravity, state, rows):
    """Write the motion of the base to position 0 of the rows."""
    zero = splat(0.0, load(state.rates, 0))
    nothing = zero, zero, zero
    up = splat(-gravity[0], zero), splat(-gravity[1], zero), splat(-gravity[2], zero)
    store_motion(rows.motions, 0, nothing, nothing, up)


@kernel
def move(mechanism, i, state, rows):
    """Perform steps 1 and 2 for one joint."""
    joints = mechanism.joints
    pose = turned_joint_pose(joints, i, state.turns)
    store_pose(rows.poses, i, pose)
    w, dw, a = load_motion(rows.motions, int(joints[i, PARENT]) + 1)
    p = origin(pose)
    a = rotate_inverse(pose, plus(a, plus(cross(dw, p), cross(w, cross(w, p)))))
    w, dw = rotate_inverse(pose, w), rotate_inverse(pose, dw)
    rate = load(state.rates, int(joints[i, COLUMN])) * joints[i, RATIO]
    acceleration = load(state.accelerations, int(joints[i, COLUMN])) * joints[i, RATIO]
    if int(joints[i, KIND]) == PRISMATIC:
        a = a[0] + 2.0 * (w[1] * rate), a[1] - 2.0 * (w[0] * rate), a[2] + acceleration
    else:
        dw = dw[0] + w[1] * rate, dw[1] - w[0] * rate, dw[2] + acceleration
        w = w[0], w[1], w[2] + rate
    store_motion(rows.motions, i + 1, w, dw, a)
    mass, moment, tensor = body_inertia(mechanism.bodies, i, rate)
    force = plus(scaled(a, mass), plus(cross(dw, moment), cross(w, cross(w, moment))))
    turning = plus(symmetric_times(tensor, dw), cross(w, symmetric_times(tensor, w)))
    store_pair(rows.wrenches, i, force, plus(turning, cross(moment, a)))


@kernel
def carry(joints, i, rows, torque_rows):
    """Perform step 3 for one joint."""
    force, moment = load_pair(rows.wrenches, i)
    column = int(joints[i, COLUMN])
    along = force[2] if int(joints[i, KIND]) == PRISMATIC else moment[2]
    store(torque_rows, column, load(torque_rows, column) + along * joints[i, RATIO])
    parent = int(joints[i, PARENT])
    if parent >= 0:
        pose = load_pose(rows.poses, i)
        turned = rotate(pose, force)
        add_pair(rows.wrenches, parent, turned, plus(rotate(pose, moment), cross(origin(pose), turned)))


@kernel
def load_motion(rows, i):
    """Load the angular velocity and acceleration of a frame, and the acceleration of its origin."""
    k = MOTION_WIDTH * i
    return load_vector(rows, k), load_vector(rows, k + 3), load_vector(rows, k + 6)


@kernel
def store_motion(rows, i, w, dw, a):
    """Write the motion of a frame to position i of the rows."""
    k = MOTION_WIDTH * i
    store_vector(rows, k, w)
    store_vector(rows, k + 3, dw)
    store_vector(rows, k + 6, a)
