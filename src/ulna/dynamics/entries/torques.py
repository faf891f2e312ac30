"""Runs inverse dynamics, its derivatives and gravity torques over a batch."""

from ulna.dynamics.entries.rows import FORCE_ROWS, MECHANISM, body_rows, fall_rows, force_rows, rate_rows
from ulna.engine.decorators import entry, kernel, low_latency_entry
from ulna.engine.lanes import WIDTH, zero_rows
from ulna.engine.signatures import CONSTANTS, MATRICES, MATRIX, NUMBERS
from ulna.kernels.chain.poses import joint_turns
from ulna.kernels.dynamics.derivatives import torque_derivatives
from ulna.kernels.dynamics.dynamics_records import State
from ulna.kernels.dynamics.gravity import holding_torques
from ulna.kernels.dynamics.newton_euler import newton_euler
from ulna.kernels.spatial.elementary import all_finite, all_in_range
from ulna.kinematics.entries.batch import gather, scatter_rows


@kernel
def read_motion(joints, motion, start, q_rows, state):
    """Read eight rows of a motion, from row ``start``, into a state. False if a number is not valid.

    q must be in range, and its rates finite.
    """
    gather(motion[0], start, q_rows)
    gather(motion[1], start, state.rates)
    gather(motion[2], start, state.accelerations)
    joint_turns(joints, q_rows, state.turns)
    return all_in_range(q_rows) and all_finite(state.rates) and all_finite(state.accelerations)


@low_latency_entry((MECHANISM, CONSTANTS, FORCE_ROWS, NUMBERS, NUMBERS, NUMBERS, NUMBERS, NUMBERS))
def inverse_one(mechanism, gravity, rows, turn_rows, q, qd, qdd, out):
    """Write the torques of one motion to out, all of shape (n_dof,).

    It returns False and writes nothing if q is out of range, a rate is not finite, or an array has another length. It holds the
    GIL, so all calls may share ``rows`` and ``turn_rows``.
    """
    n_dof = out.shape[0]
    if q.shape[0] != n_dof or qd.shape[0] != n_dof or qdd.shape[0] != n_dof:
        return False
    if not (all_in_range(q) and all_finite(qd) and all_finite(qdd)):
        return False
    joint_turns(mechanism.joints, q, turn_rows)
    newton_euler(mechanism, (gravity[0], gravity[1], gravity[2]), State(turn_rows, qd, qdd), rows, out)
    return True


@entry((MECHANISM, CONSTANTS, MATRIX, MATRIX, MATRIX, MATRIX))
def inverse_batch(mechanism, gravity, q, qd, qdd, out):
    """Write the torques of motions to out, all of shape (n, n_dof), eight rows at a time.

    False if q is out of range, or a rate is not finite.
    """
    joints, n_dof = mechanism.joints, q.shape[1]
    q_rows, torque_rows = zero_rows(n_dof), zero_rows(n_dof)
    rows, state = force_rows(joints.shape[0]), State(zero_rows(2 * joints.shape[0]), zero_rows(n_dof), zero_rows(n_dof))
    free_fall = gravity[0], gravity[1], gravity[2]
    good = True
    for start in range(0, q.shape[0], WIDTH):
        good &= read_motion(joints, (q, qd, qdd), start, q_rows, state)
        newton_euler(mechanism, free_fall, state, rows, torque_rows)
        scatter_rows(torque_rows, n_dof, out, start)
    return good


@entry((MECHANISM, CONSTANTS, MATRIX, MATRIX))
def gravity_batch(mechanism, gravity, q, out):
    """Write the gravity torques for q to out, both of shape (n, n_dof), eight rows at a time.

    False if q is out of range.
    """
    joints, n_dof = mechanism.joints, q.shape[1]
    q_rows, torque_rows, turn_rows = zero_rows(n_dof), zero_rows(n_dof), zero_rows(2 * joints.shape[0])
    rows, free_fall = fall_rows(joints.shape[0]), (gravity[0], gravity[1], gravity[2])
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        joint_turns(joints, q_rows, turn_rows)
        holding_torques(mechanism, free_fall, turn_rows, rows, torque_rows)
        scatter_rows(torque_rows, n_dof, out, start)
    return good


@entry((MECHANISM, CONSTANTS, MATRIX, MATRIX, MATRIX, MATRICES, MATRICES))
def derivatives_batch(mechanism, gravity, q, qd, qdd, by_q, by_rate):
    """Write the derivatives of the torques with respect to q and qd, shape (n, n_dof, n_dof) each.

    Entry (r, c) is the derivative of torque r. False if q is out of range, or a rate is not finite.
    """
    joints, n_dof = mechanism.joints, q.shape[1]
    q_rows, state = zero_rows(n_dof), State(zero_rows(2 * joints.shape[0]), zero_rows(n_dof), zero_rows(n_dof))
    work = body_rows(joints.shape[0]), rate_rows(joints.shape[0])
    derivative_rows = zero_rows(n_dof * n_dof), zero_rows(n_dof * n_dof)
    free_fall = gravity[0], gravity[1], gravity[2]
    good = True
    for start in range(0, q.shape[0], WIDTH):
        good &= read_motion(joints, (q, qd, qdd), start, q_rows, state)
        torque_derivatives(mechanism, free_fall, state, n_dof, work, derivative_rows)
        scatter_rows(derivative_rows[0], n_dof * n_dof, by_q, start)
        scatter_rows(derivative_rows[1], n_dof * n_dof, by_rate, start)
    return good
