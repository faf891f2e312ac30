"""Runs Levenberg-Marquardt from several starts on a GPU, a target a thread. Used by ``robot.gpu_robot``."""

from functools import cache

import numpy as np

from ulna.drivers.lane_state import reset_state, write_bounds, write_result, write_start, write_target
from ulna.engine.gpu import cuda
from ulna.kernels.ik.levenberg_marquardt import ENDED, HAS_SOLVED, N_STATE, P2, R2, RUNNING, advance
from ulna.kernels.ik.scratch_layout import N_SYSTEM
from ulna.kernels.ik.search_layout import NOT_A_POSE, NOT_FOUND, STATUS, STEPS, WITH_POSTURE
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect


@cache
def searches_of(n_dof: int):
    """The driver for robots of so many joints.

    A thread takes a target, searches from one start after the other until it is solved, and takes the next target. All threads of
    a warp take a step at the same time, whatever targets they have. The result of a target does not depend on its thread.
    """
    twice, of_jacobian = 2 * n_dof, 6 * n_dof

    def searches(chain, seeds, box, samples, posture, settings, following, targets, q_out, info, _):
        """The arguments are those of ``drivers.multi_start``; ``following``: the number of the next target, shape (1,)."""
        q_rows, last_rows = cuda.local.array((1, n_dof), np.float64), cuda.local.array((1, n_dof), np.float64)
        target_rows, bound_rows = cuda.local.array((1, 12), np.float64), cuda.local.array((1, twice), np.float64)
        state_rows, jacobian = cuda.local.array((1, N_STATE), np.float64), cuda.local.array(of_jacobian, np.float64)
        system = cuda.local.array(N_SYSTEM, np.float64)
        rows = q_rows[0], last_rows[0], target_rows[0], bound_rows[0], state_rows[0]  # as the kernels take them
        q, last, target, bound, state = q_rows.T, last_rows.T, target_rows.T, bound_rows.T, state_rows.T  # as one lane of several
        start, is_new, best = 0, True, np.inf
        i = cuda.atomic.add(following, 0, 1)
        while i < targets.shape[0]:
            seed = seeds[min(i, seeds.shape[0] - 1)]
            if start == 0 and is_new and not (rigidity_defect(targets[i]) <= LARGEST_DEFECT and all_in_range(seed)):
                info[i, STATUS] = NOT_A_POSE
                i = cuda.atomic.add(following, 0, 1)
                continue
            if is_new:
                if start == 0:
                    best, info[i, STATUS] = np.inf, NOT_FOUND
                write_target(matrix_pose(targets[i]), target, 0)
                write_bounds(box, bound, 0)
                write_start(box, seed, samples, start, q, 0)
                reset_state(state, settings[STEPS], settings[WITH_POSTURE], 0)
                is_new = False
            advance(chain, posture, settings, rows, (jacobian, system))
            if state[ENDED, 0] != RUNNING:
                missed, solved = state[P2, 0] + state[R2, 0], state[ENDED, 0] == HAS_SOLVED
                if solved or missed < best:
                    write_result(last, target, state, 0, start, i, q_out, info)
                    best = missed
                start, is_new = start + 1, True
                if solved or start == samples.shape[0]:
                    start, i = 0, cuda.atomic.add(following, 0, 1)

    return searches
