"""Runs the mass matrix, forward dynamics and the center of mass over a batch."""

from ulna.dynamics.entries.rows import MECHANISM, body_rows, force_rows
from ulna.engine.decorators import entry
from ulna.engine.lanes import WIDTH, load, store, zero_rows
from ulna.engine.signatures import CONSTANTS, MATRICES, MATRIX
from ulna.kernels.chain.poses import joint_turns
from ulna.kernels.dynamics.composite import mass_matrix, moment_columns
from ulna.kernels.dynamics.dynamics_records import State
from ulna.kernels.dynamics.forward_dynamics import accelerations
from ulna.kernels.dynamics.newton_euler import newton_euler
from ulna.kernels.spatial.elementary import all_finite, all_in_range
from ulna.kinematics.entries.batch import gather, scatter_rows


@entry((MECHANISM, MATRIX, MATRICES))
def mass_batch(mechanism, q, out):
    """Write the mass matrices for q, shape (n, n_dof), to out, shape (n, n_dof, n_dof).

    It processes eight rows at a time. False if q is out of range.
    """
    joints, n_dof = mechanism.joints, q.shape[1]
    q_rows, turn_rows, mass_rows = zero_rows(n_dof), zero_rows(2 * joints.shape[0]), zero_rows(n_dof * n_dof)
    rows = body_rows(joints.shape[0])
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        joint_turns(joints, q_rows, turn_rows)
        mass_matrix(mechanism, turn_rows, n_dof, rows, mass_rows)
        scatter_rows(mass_rows, n_dof * n_dof, out, start)
    return good


@entry((MECHANISM, CONSTANTS, MATRIX, MATRIX, MATRIX, MATRIX))
def forward_batch(mechanism, gravity, q, qd, torque, out):
    """Write the accelerations to out, all of shape (n, n_dof), eight rows at a time.

    False if q is out of range, or a rate or a torque is not finite. A row with a singular mass matrix becomes NaN.
    """
    joints, n_dof = mechanism.joints, q.shape[1]
    q_rows, turn_rows, torque_rows = zero_rows(n_dof), zero_rows(2 * joints.shape[0]), zero_rows(n_dof)
    mass_rows, system_rows = zero_rows(n_dof * n_dof), zero_rows(n_dof * (n_dof + 1) // 2 + n_dof)
    state = State(turn_rows, zero_rows(n_dof), zero_rows(n_dof))
    forces, bodies = force_rows(joints.shape[0]), body_rows(joints.shape[0])
    free_fall = gravity[0], gravity[1], gravity[2]
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        gather(qd, start, state.rates)
        good &= all_in_range(q_rows) and all_finite(state.rates)
        joint_turns(joints, q_rows, turn_rows)
        newton_euler(mechanism, free_fall, state, forces, torque_rows)
        mass_matrix(mechanism, turn_rows, n_dof, bodies, mass_rows)
        gather(torque, start, q_rows)
        good &= all_finite(q_rows)
        for j in range(n_dof):
            store(torque_rows, j, load(q_rows, j) - load(torque_rows, j))
        accelerations(mass_rows, torque_rows, system_rows)
        scatter_rows(torque_rows, n_dof, out, start)
    return good


@entry((MECHANISM, MATRIX, MATRIX, MATRICES))
def moment_batch(mechanism, q, moments, columns):
    """Write the total mass and first moment of all moving bodies for q, shape (n, n_dof).

    moments: mass [kg] and moment [kg m], shape (n, 4). columns: the moment's derivative with respect to each entry of q, shape
    (n, n_dof, 3). False if q is out of range.
    """
    joints, n_dof = mechanism.joints, q.shape[1]
    q_rows, turn_rows = zero_rows(n_dof), zero_rows(2 * joints.shape[0])
    rows, column_rows, moment_rows = body_rows(joints.shape[0]), zero_rows(3 * n_dof), zero_rows(4)
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        joint_turns(joints, q_rows, turn_rows)
        mass, moment = moment_columns(mechanism, turn_rows, rows, column_rows)
        store(moment_rows, 0, mass)
        for k in range(3):
            store(moment_rows, k + 1, moment[k])
        scatter_rows(moment_rows, 4, moments, start)
        scatter_rows(column_rows, 3 * n_dof, columns, start)
    return good
