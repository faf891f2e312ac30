"""Finds all eight branches of inverse kinematics in closed form, eight targets at a time, or one. Used by ``ik.closed_form``."""

import numpy as np

from ulna.drivers.batch import gather
from ulna.engine.decorators import entry, kernel, workspace
from ulna.engine.lanes import any_lane, load, store
from ulna.engine.signatures import MATRICES, MATRIX, NUMBER, TABLE, WHOLE
from ulna.engine.width import WIDTH
from ulna.kernels.chain.closed_form import closed_form
from ulna.kernels.chain.closed_form_layout import COLUMNS, FORM, INVERSE_REACH, N_BRANCHES, N_KNOWN, SIGNS
from ulna.kernels.ik.polish import ENOUGH, polish
from ulna.kernels.ik.scratch_layout import N_SYSTEM
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.elementary import sincos
from ulna.kernels.spatial.se3 import rigidity_defect

N_AXES = 6


@workspace
def branch_state(n):
    """Rows of signs, free angles, the target, q and what is known, for n^3 branches; and the scratch of a polish."""
    branches = n * n * n
    target, q, known = 3 * n + 2 * N_AXES, 3 * n + 2 * N_AXES + 12, 3 * n + 2 * N_AXES + 12 + N_AXES * branches
    jacobian = known + N_KNOWN * branches
    system = jacobian + 6 * N_AXES
    block = np.zeros((system + N_SYSTEM + N_AXES, WIDTH))
    for k in range(3 * n):
        for lane in range(WIDTH):
            bit = (lane >> (2 - k)) & 1 if n == 1 else k & 1
            block[k, lane] = 1.0 - 2.0 * bit
    block[target - N_AXES : target] = 1.0  # the cosines of free angles
    rows = block[: 3 * n], block[3 * n : target], block[target:q], block[q:known], block[known:jacobian]
    return rows, (block[jacobian:system], block[system : system + N_SYSTEM], block[system + N_SYSTEM :])


@kernel
def write_free_angles(table, angle_rows, free_rows):
    """Write the sines and cosines of the angles about the axes that a seed gives. angle_rows: q, six."""
    for j in range(N_AXES):
        sign = table[SIGNS + j // 3, j % 3]
        s, c = sincos(load(angle_rows, int(table[COLUMNS + j // 3, j % 3])) * sign)
        store(free_rows, j, s)
        store(free_rows, N_AXES + j, c)


@workspace
def polish_branches(table, chain, most, steps, rows, scratch):
    """Polish the branches of the rows of ``branch_state``."""
    _, _, target_rows, q_rows, known_rows = rows
    jacobian_rows, system_rows, last_rows = scratch
    for k in range(q_rows.shape[0] // N_AXES):
        error = load(known_rows, N_KNOWN * k)
        if any_lane((error > ENOUGH) & (error <= most)):
            polish(
                chain, target_rows, q_rows[N_AXES * k : N_AXES * (k + 1)], known_rows[N_KNOWN * k : N_KNOWN * (k + 1)],
                table[FORM, INVERSE_REACH], most, steps, jacobian_rows, system_rows, last_rows,
            )  # fmt: skip


@kernel
def gather_targets(targets, start, target_rows):
    """Rows of the eight targets from ``start`` on. False if one is no rigid motion."""
    good = True
    for lane in range(WIDTH):
        i = min(start + lane, targets.shape[0] - 1)
        good &= rigidity_defect(targets[i]) <= LARGEST_DEFECT
        for k in range(12):
            target_rows[k, lane] = targets[i, k // 4, k % 4]
    return good


@entry((TABLE, TABLE, MATRICES, MATRIX, NUMBER, WHOLE, MATRICES, MATRICES))
def all_branches(table, chain, targets, seeds, most, steps, q_out, known):
    """All branches of targets (n, 4, 4), with what is known of each (``closed_form_layout``). False if a target is no pose.

    table: of the closed form; chain: of the six joints that it turns. seeds: (n or 1, 6), the angles of joints that may have any.
    most, steps: of ``polish``. q_out: (n, 8, 6); known: (n, 8, N_KNOWN).
    """
    n = targets.shape[0]
    rows, scratch = branch_state(2)
    sign_rows, free_rows, target_rows, q_rows, known_rows = rows
    good = True
    for start in range(0, n, WIDTH):
        if start == 0 or seeds.shape[0] > 1:
            gather(seeds, start, scratch[2])
            write_free_angles(table, scratch[2], free_rows)
        good &= gather_targets(targets, start, target_rows)
        closed_form(table, target_rows, sign_rows, 2, free_rows, q_rows, known_rows)
        polish_branches(table, chain, most, steps, rows, scratch)
        for lane in range(WIDTH):
            i = min(start + lane, n - 1)
            for branch in range(N_BRANCHES):
                for j in range(N_AXES):
                    q_out[i, branch, j] = q_rows[N_AXES * branch + j, lane]
                for k in range(N_KNOWN):
                    known[i, branch, k] = known_rows[N_KNOWN * branch + k, lane]
    return good
