"""Finds all branches of inverse kinematics of six joints on a GPU, a branch a thread. Used by ``robot.gpu_solutions``.

The eight branches of a target are in threads beside each other, as they are in the eight lanes of a vector on the CPU where there
is one target. A thread that computed all of them would have more numbers at a time than registers (3 kB spilled; so, none).
"""

import numpy as np

from ulna.drivers.branch_rows import N_AXES, polish_branches, put_at_limits, write_free_angles
from ulna.drivers.closed_form import N_OPTIONS
from ulna.engine.gpu import cuda
from ulna.kernels.chain.closed_form import closed_form
from ulna.kernels.chain.closed_form_layout import IS_REAL, IS_WITHIN, N_BRANCHES, N_KNOWN
from ulna.kernels.chain.closed_form_rows import known_in_one
from ulna.kernels.ik.nearest_branch import is_any_hardly_beyond, turn_within
from ulna.kernels.ik.scratch_layout import N_SYSTEM
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect

_N_SIGNS, _FREE, _OF_JACOBIAN = 3, 2 * N_AXES, 6 * N_AXES


def branches(table, chain, plan, columns, seeds, targets, q_out, known_out, real, valid, not_a_pose):
    """All branches of targets (n, 4, 4), with what is known of each; set the flag if a target is no rigid motion.

    table, chain, plan, seeds, and what is written to q_out (n, 8, 6) and known_out (n, 8): those of
    ``drivers.closed_form.all_branches``. columns: which entry of q_out each joint is. real, valid: (n, 8), whether a branch
    reaches the target, and whether it is within the bounds too.
    """
    thread = cuda.grid(1)
    i, branch = thread // N_BRANCHES, thread % N_BRANCHES
    if i < targets.shape[0]:
        if not rigidity_defect(targets[i]) <= LARGEST_DEFECT:
            not_a_pose[0] = 1
        signs, free = cuda.local.array(_N_SIGNS, np.float64), cuda.local.array(_FREE, np.float64)
        target, q = cuda.local.array(12, np.float64), cuda.local.array(N_AXES, np.float64)
        known, jacobian = cuda.local.array(N_KNOWN, np.float64), cuda.local.array(_OF_JACOBIAN, np.float64)
        system, last = cuda.local.array(N_SYSTEM, np.float64), cuda.local.array(N_AXES, np.float64)
        inside, error = cuda.local.array(N_AXES, np.float64), cuda.local.array(1, np.float64)
        seed, bounds = seeds[min(i, seeds.shape[0] - 1)], plan[N_OPTIONS:]
        for k in range(_N_SIGNS):
            signs[k] = 1.0 - 2.0 * ((branch >> (_N_SIGNS - 1 - k)) & 1)
        pose = matrix_pose(targets[i])
        for k in range(12):
            target[k] = pose[k]
        write_free_angles(table, seed, free)
        closed_form(table, target, signs, 1, free, q, known)
        polish_branches(table, chain, (signs, free, target, q, known), (jacobian, system, last))
        if bounds.shape[0] > 0 and is_any_hardly_beyond(q, known, bounds):
            put_at_limits(table, chain, (signs, free, target, q, known), (jacobian, system, last), seed, bounds, inside, error)
        known[0] = known_in_one(known, 0)
        if bounds.shape[0] > 0:
            turn_within(q, known, 0, seed, bounds)
        bits = int(known[0])
        known_out[i, branch], real[i, branch], valid[i, branch] = bits, (bits & IS_REAL) > 0, (bits & IS_WITHIN) > 0
        for j in range(N_AXES):
            q_out[i, branch, columns[j]] = q[j]
