"""Computes gravity torques, each body in the frame of its joint.

The potential energy of bodies is -g . h, with their first moment h (mass times center of mass). The torque of a joint is its
derivative: -g . (z x h) for a revolute joint, with h about its origin, and -m g . z for a prismatic joint.

Source: Siciliano et al., Robotics (2009), section 7.1.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, store
from ulna.kernels.chain.jacobian import clear
from ulna.kernels.chain.poses import turned_joint_pose
from ulna.kernels.dynamics.composite import add_to
from ulna.kernels.layout import COLUMN, KIND, MASS, MOMENT, PARENT, PRISMATIC, RATIO
from ulna.kernels.spatial.se3 import load_pose, store_pose
from ulna.kernels.spatial.vectors import add_scaled, load_vector, origin, plus, rotate, rotate_inverse, store_vector


@kernel
def holding_torques(mechanism, gravity, turn_rows, rows, torque_rows):
    """Write the gravity torques [Nm or N] of all entries of q to torque_rows.

    1. From the base to the tips: compute the gravitational acceleration in the frame of each joint.
    2. From the tips to the base: compute the mass and the moment of each joint's subtree.

    Args:
        mechanism: The table of joints and the table of inertias, one row per joint.
        gravity: The gravitational acceleration [m/s^2] in the axes of the base: three plain numbers.
        turn_rows: The output of ``joint_turns``.
        rows: ``FallRows`` as workspace.
        torque_rows: One row for each entry of q.
    """
    joints, like = mechanism.joints, load(turn_rows, 0)
    fall = splat(gravity[0], like), splat(gravity[1], like), splat(gravity[2], like)
    store_vector(rows.falls, 0, fall)
    for i in range(joints.shape[0]):
        parent, pose = int(joints[i, PARENT]), turned_joint_pose(joints, i, turn_rows)
        store_pose(rows.poses, i, pose)
        if parent != i - 1:  # otherwise it is the previous value
            fall = load_vector(rows.falls, 3 * (parent + 1))
        fall = rotate_inverse(pose, fall)
        store_vector(rows.falls, 3 * (i + 1), fall)
        store(rows.masses, i, splat(mechanism.bodies[i, MASS], like))
        for k in range(3):
            store(rows.moments, 3 * i + k, splat(mechanism.bodies[i, MOMENT + k], like))
    clear(torque_rows, like)
    zero = splat(0.0, like)
    held = zero, (zero, zero, zero)
    for k in range(joints.shape[0]):
        held = hold(joints, joints.shape[0] - 1 - k, held, rows, torque_rows)


@kernel
def hold(joints, i, held, rows, torque_rows):
    """Perform step 2 for one joint. held: the mass and the moment passed on by the next joint.

    Returns:
        The mass and the moment to pass on to the previous joint, in its frame; 0 if that is not the parent.
    """
    mass, moment = load(rows.masses, i) + held[0], plus(load_vector(rows.moments, 3 * i), held[1])
    fall, parent = load_vector(rows.falls, 3 * (i + 1)), int(joints[i, PARENT])
    along = -mass * fall[2] if int(joints[i, KIND]) == PRISMATIC else moment[1] * fall[0] - moment[0] * fall[1]
    add_to(torque_rows, int(joints[i, COLUMN]), along * joints[i, RATIO])
    pose = load_pose(rows.poses, i)
    moment = add_scaled(rotate(pose, moment), mass, origin(pose))
    if parent != i - 1:
        if parent >= 0:
            add_to(rows.masses, parent, mass)
            store_vector(rows.moments, 3 * parent, plus(load_vector(rows.moments, 3 * parent), moment))
        mass = splat(0.0, along)
        moment = mass, mass, mass
    return mass, moment
