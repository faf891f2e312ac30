"""Runs dynamics on a GPU, one motion per thread, by the kernels of the CPU (``ulna.kernels.dynamics``).

The tables of each driver are the joints, the bodies, and three numbers for the acceleration of free fall. A row is q; or q, its
rates and its accelerations (or torques) in sequence.
"""

from functools import cache
from typing import Any

from ulna.engine.decorators import kernel
from ulna.gpu.staged import over_rows
from ulna.kernels.chain.poses import joint_turns
from ulna.kernels.dynamics.composite import mass_matrix
from ulna.kernels.dynamics.derivatives import torque_derivatives
from ulna.kernels.dynamics.dynamics_records import MOTION_WIDTH, BodyRows, FallRows, ForceRows, Mechanism, RateRows, State
from ulna.kernels.dynamics.forward_dynamics import accelerations
from ulna.kernels.dynamics.gravity import holding_torques
from ulna.kernels.dynamics.newton_euler import newton_euler
from ulna.kernels.layout import INERTIA_WIDTH
from ulna.kernels.spatial.elementary import all_finite, all_in_range

_OF_FORCES = MOTION_WIDTH + 12 + 6  # numbers of ``ForceRows`` for each joint
_OF_BODIES = 12 + 6 + INERTIA_WIDTH  # of ``BodyRows``
_OF_FALLS = 12 + 3 + 3 + 1  # of ``FallRows``
_OF_RATES = 7 * 6  # of ``RateRows``


@cache
def gravity_of(n_dof: int, n_joints: int) -> Any:
    """The driver of the torques that hold a robot still: rows of n_dof."""
    return over_rows(_gravity, n_dof, n_dof, scratch=(_OF_FALLS + 2) * n_joints + 3)


@cache
def masses_of(n_dof: int, n_joints: int) -> Any:
    """The driver of mass matrices: rows of n_dof^2."""
    return over_rows(_masses, n_dof, n_dof * n_dof, scratch=(_OF_BODIES + 2) * n_joints)


@cache
def inverse_of(n_dof: int, n_joints: int, beside: int) -> Any:
    """The driver of inverse dynamics: torques, rows of n_dof.

    beside: 2 if q, the rates and the accelerations are three arrays; 0 if they are one.
    """
    return _over_motions(_inverse, n_dof, n_dof, (_OF_FORCES + 2) * n_joints + MOTION_WIDTH, beside)


@cache
def forward_of(n_dof: int, n_joints: int, beside: int) -> Any:
    """The driver of forward dynamics: accelerations, rows of n_dof."""
    work = (max(_OF_FORCES, _OF_BODIES) + 2) * n_joints + MOTION_WIDTH + n_dof * (n_dof + 1) // 2 + n_dof
    return _over_motions(_forward, n_dof, n_dof, work + n_dof + n_dof * n_dof, beside)


@cache
def derivatives_of(n_dof: int, n_joints: int, beside: int) -> Any:
    """The driver of the derivatives of torques: by q, rows of n_dof^2, and by the rates to ``marks[1]``."""
    return _over_motions(_derivatives, n_dof, n_dof * n_dof, (_OF_BODIES + _OF_RATES + 2) * n_joints, beside)


def _over_motions(formula: Any, n_dof: int, given: int, scratch: int, beside: int) -> Any:
    return over_rows(formula, n_dof if beside else 3 * n_dof, given, beside=beside, scratch=scratch)


@kernel
def _inverse(tables, row, _place, scratch, out, _marks):
    """Write the torques of a motion; returns whether it is invalid."""
    return not _driven(tables, _state_of(tables[0], row, scratch), row, scratch[2 * tables[0].shape[0] :], out)


@kernel
def _gravity(tables, q, _place, scratch, out, _marks):
    """Write the torques that hold q; returns whether an entry of q is out of range."""
    n, own = tables[0].shape[0], scratch[2 * tables[0].shape[0] :]
    rows = FallRows(own[: 12 * n], own[12 * n : 15 * n + 3], own[15 * n + 3 : 18 * n + 3], own[18 * n + 3 :])
    joint_turns(tables[0], q, scratch[: 2 * n])
    holding_torques(Mechanism(tables[0], tables[1]), _free_fall(tables), scratch[: 2 * n], rows, out)
    return not all_in_range(q)


@kernel
def _masses(tables, q, _place, scratch, out, _marks):
    """Write M; returns whether an entry of q is out of range."""
    n = tables[0].shape[0]
    joint_turns(tables[0], q, scratch[: 2 * n])
    mass_matrix(Mechanism(tables[0], tables[1]), scratch[: 2 * n], q.shape[0], _body_rows(n, scratch[2 * n :]), out)
    return not all_in_range(q)


@kernel
def _forward(tables, row, _place, scratch, out, _marks):
    """Write the accelerations that torques cause; returns whether the row is invalid, or its mass matrix singular.

    M a = tau - tau_0, with the torques tau_0 of the same motion without accelerations.
    """
    n, n_dof = tables[0].shape[0], out.shape[0]
    masses, rest = scratch[: n_dof * n_dof], scratch[n_dof * n_dof :]
    torque, own = rest[:n_dof], rest[n_dof:]
    for j in range(n_dof):
        torque[j], row[2 * n_dof + j] = row[2 * n_dof + j], 0.0
    good = _driven(tables, _state_of(tables[0], row, own), row, own[2 * n :], out) and all_finite(torque)
    mass_matrix(Mechanism(tables[0], tables[1]), own[: 2 * n], n_dof, _body_rows(n, own[2 * n :]), masses)
    for j in range(n_dof):
        out[j] = torque[j] - out[j]
    accelerations(masses, out, own)
    return not good or out[0] != out[0]


@kernel
def _derivatives(tables, row, place, scratch, out, marks):
    """Write the derivatives of the torques by q, and by the rates to ``marks[1]``; returns whether the row is invalid."""
    joints, n, n_dof = tables[0], tables[0].shape[0], row.shape[0] // 3
    state, own, rest = _state_of(joints, row, scratch), scratch[2 * n :], scratch[(2 + _OF_BODIES) * n :]
    rates = RateRows(
        rest[: 6 * n], rest[6 * n : 12 * n], rest[12 * n : 18 * n], rest[18 * n : 24 * n], rest[24 * n : 30 * n],
        rest[30 * n : 36 * n], rest[36 * n :],
    )  # fmt: skip
    work, written = (_body_rows(n, own), rates), (out, marks[1][place[0]])
    torque_derivatives(Mechanism(joints, tables[1]), _free_fall(tables), state, n_dof, work, written)
    return not _is_good(row)


@kernel
def _driven(tables, state, row, own, out):
    """Write the torques of a motion; returns whether it is valid."""
    n = tables[0].shape[0]
    motions = MOTION_WIDTH * (n + 1)
    rows = ForceRows(own[:motions], own[motions : motions + 12 * n], own[motions + 12 * n : motions + 18 * n])
    newton_euler(Mechanism(tables[0], tables[1]), _free_fall(tables), state, rows, out)
    return _is_good(row)


@kernel
def _state_of(joints, row, turn_rows):
    """The state of a row of q, rates and accelerations; writes the joints' turns to the scratch."""
    n_dof = row.shape[0] // 3
    joint_turns(joints, row[:n_dof], turn_rows)
    return State(turn_rows[: 2 * joints.shape[0]], row[n_dof : 2 * n_dof], row[2 * n_dof :])


@kernel
def _is_good(row):
    """Whether q is in range, and its rates and accelerations are finite."""
    n_dof = row.shape[0] // 3
    return all_in_range(row[:n_dof]) and all_finite(row[n_dof:])


@kernel
def _body_rows(n, own):
    """``BodyRows`` of n joints."""
    return BodyRows(own[: 12 * n], own[12 * n : 18 * n], own[18 * n : (18 + INERTIA_WIDTH) * n])


@kernel
def _free_fall(tables):
    """The acceleration of free fall."""
    return tables[2], tables[3], tables[4]
