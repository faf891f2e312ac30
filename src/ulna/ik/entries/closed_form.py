"""Finds all eight branches of inverse kinematics in closed form, for eight targets at a time, or for one."""

import numpy as np

from ulna.engine.decorators import entry, kernel, workspace
from ulna.engine.lanes import WIDTH, lane_of, load, splat, store, where, zero_rows
from ulna.engine.signatures import MATRICES, MATRIX, NUMBER, NUMBERS, TABLE, TRUTH_ROWS, WHOLE, Array
from ulna.ik.entries.branch_rows import (
    N_AXES,
    branch_state,
    move_to_limits,
    polish_branches,
    polish_seed,
    polish_state,
    write_free_angles,
    write_seed,
)
from ulna.ik.entries.lane_state import store_state, write_result, write_target
from ulna.kernels.chain.closed_form import closed_form
from ulna.kernels.chain.closed_form_layout import (
    IS_REAL,
    IS_WITHIN,
    N_BOUNDS,
    N_BRANCHES,
    N_KNOWN,
)
from ulna.kernels.chain.closed_form_rows import proof_of, proof_of_lanes, properties_in_one
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import error_squares, pose_error
from ulna.kernels.ik.levenberg_marquardt import HAS_FAILED, HAS_SOLVED, N_STATE
from ulna.kernels.ik.nearest_branch import is_any_hardly_beyond, nearest_branch, polish, turn_within
from ulna.kernels.ik.search_layout import NOT_A_POSE, SOLVED
from ulna.kernels.ik.search_records import SearchResult
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import load_pose, matrix_pose, rigidity_defect
from ulna.kinematics.entries.batch import gather, gather_poses, scatter_rows

_RESULTS = Array(SearchResult, 1)
_FEW = 4  # targets up to this number take no longer one by one
N_OPTIONS = 2  # options in a plan


@entry((TABLE, TABLE, NUMBERS, MATRICES, MATRIX, MATRICES, MATRIX, NUMBERS))
def all_branches(table, chain, plan, targets, seeds, q_out, known, proof):
    """All branches of targets (n, 4, 4), with their properties (``closed_form_layout``). False if a target is no pose.

    Args:
        table: The table of the closed form.
        chain: The chain of the six joints.
        plan: As in ``nearest_branches``, or without its bounds. With bounds, whole turns bring branches towards the seeds within
            the bounds, and q is NaN for branches that are not real.
        targets: Shape (n, 4, 4).
        seeds: Shape (n or 1, 6); also the values of undetermined joints.
        q_out: Shape (n, 8, 6), output.
        known: The flags of each branch in one number, shape (n, 8), output.
        proof: Shape (n,), output; -1 for a target that is no pose.
    """
    n, with_bounds = targets.shape[0], plan.shape[0] > N_OPTIONS
    n_signs = 1 + q_out.shape[1] // N_BRANCHES  # 2: with a constant the compiler would make other code than for one target
    rows, scratch = branch_state(2)
    _, free_rows, target_rows, q_rows, known_rows = rows
    best, good = best_state(plan), True
    seed_rows, bound_rows = best[0], best[1]
    for start in range(0, n, WIDTH):
        if start == 0 or seeds.shape[0] > 1:
            gather(seeds, start, seed_rows)
            write_free_angles(table, seed_rows, free_rows)
        gather_poses(targets, start, target_rows)
        write_branches(table, chain, n_signs, rows, scratch, best, with_bounds)
        good &= write_proof(known_rows, targets, start, proof)
        for branch in range(N_BRANCHES):
            store(
                known_rows, branch, properties_in_one(known_rows, branch)
            )  # the flags of earlier branches are already in one number
            if with_bounds:
                turn_within(q_rows[N_AXES * branch : N_AXES * (branch + 1)], known_rows, branch, seed_rows, bound_rows)
        scatter_rows(q_rows, N_BRANCHES * N_AXES, q_out, start)
        scatter_rows(known_rows, N_BRANCHES, known, start)
    return good


@entry((TABLE, TABLE, NUMBERS, NUMBERS, MATRIX, MATRIX, TRUTH_ROWS))
def all_branches_of_one(table, chain, plan, seed, target, q_out, truths):
    """All branches of one target (4, 4), a branch a lane; their proof, or -1 for no pose.

    They have the same bits as from ``all_branches``.

    plan: With bounds. seed: (6,). q_out: (8, 6). truths: (2, 8), whether each branch is within the bounds, and whether it is
    real.
    """
    if not rigidity_defect(target) <= LARGEST_DEFECT:
        return -1
    rows, scratch = branch_state(1)
    _, free_rows, target_rows, q_rows, known_rows = rows
    best = best_state(plan)
    seed_rows, bound_rows = best[0], best[1]
    for lane in range(WIDTH):
        write_target(matrix_pose(target), target_rows, lane)
    write_seed(seed, seed_rows)
    write_free_angles(table, seed_rows, free_rows)
    n_signs = q_out.shape[0] // N_BRANCHES  # 1; see ``all_branches``
    write_branches(table, chain, n_signs, rows, scratch, best, with_bounds=True)
    proved = proof_of_lanes(known_rows)
    store(known_rows, 0, properties_in_one(known_rows, 0))
    turn_within(q_rows, known_rows, 0, seed_rows, bound_rows)
    for branch in range(N_BRANCHES):
        known = int(known_rows[0, branch])
        truths[0, branch], truths[1, branch] = (known & IS_WITHIN) > 0, (known & IS_REAL) > 0
        for j in range(N_AXES):
            q_out[branch, j] = q_rows[j, branch]
    return proved


@kernel
def write_branches(table, chain, n_signs, rows, scratch, best, with_bounds):
    """Write all branches of the targets in the rows of ``branch_state``, polished; with bounds, put at hardly exceeded ones."""
    sign_rows, free_rows, target_rows, q_rows, known_rows = rows
    closed_form(table, target_rows, sign_rows, n_signs, free_rows, q_rows, known_rows)
    polish_branches(table, chain, rows, scratch)
    if with_bounds and is_any_hardly_beyond(q_rows, known_rows, best[1]):
        move_to_limits(table, chain, rows, scratch, (best[0], best[1]), (best[5], best[6]))


@kernel
def write_proof(known_rows, targets, start, proof):
    """Write the proof by the branches of eight targets (``closed_form_layout``), or -1 for no pose; False if one is none."""
    whole, good = proof_of(known_rows), True
    for lane in range(min(WIDTH, proof.shape[0] - start)):
        is_pose = rigidity_defect(targets[start + lane]) <= LARGEST_DEFECT
        proof[start + lane] = lane_of(whole, lane) if is_pose else -1.0
        good &= is_pose
    return good


@entry((TABLE, MATRICES, MATRIX, NUMBERS, NUMBER, WHOLE, NUMBERS))
def polish_all(chain, targets, q, bounds, inverse_reach, steps, errors):
    """Polish configurations (n, n_dof), each for its target (n, 4, 4); always True.

    bounds: The lower bounds of the first joints, then the upper ones; q is within them. Other joints are unbounded. errors: Shape
    (n,), the known errors, or any value above the allowed ones; output.
    """
    n, n_dof = q.shape
    target_rows, q_rows, error_rows, bound_rows, jacobian_rows, last_rows, system_rows = polish_state(n_dof, bounds)
    for start in range(0, n, WIDTH):
        gather_poses(targets, start, target_rows)
        gather(q, start, q_rows)
        for lane in range(WIDTH):
            error_rows[0, lane] = errors[min(start + lane, n - 1)]
        rows, scratch = (target_rows, q_rows, error_rows, bound_rows), (jacobian_rows, system_rows, last_rows)
        polish(chain, rows, inverse_reach, np.inf, steps, scratch)
        scatter_rows(q_rows, n_dof, q, start)
        for lane in range(min(WIDTH, n - start)):
            errors[start + lane] = error_rows[0, lane]
    return True


@entry((TABLE, TABLE, NUMBERS, MATRICES, MATRIX, MATRIX, _RESULTS))
def nearest_branches(table, chain, plan, targets, seeds, q_out, info):
    """Find the branch nearest to the seed within the limits for each target; True if all are solved.

    plan: The tolerances [m, rad]. Then for each of the arm's own joints, which come first: the lower limits, the upper ones, the
    whole turns (for a prismatic joint more than the limits allow), their inverses, and the units. seeds: (n or 1, 6). q_out: (n,
    6). info: (n,), as of a search (``search_records``). Fewer than _FEW targets are computed one by one, a branch a lane; more
    targets eight at a time, a target a lane. Both use the same machine code, so they give the same bits.
    """
    return run_targets(table, chain, plan, targets, seeds, q_out, info)


@entry((TABLE, TABLE, NUMBERS, MATRIX, NUMBERS, MATRIX, _RESULTS))
def nearest_branch_of_one(table, chain, plan, target, seed, q_out, info):
    """``nearest_branches`` for one target (4, 4) and one seed (6,)."""
    return run_targets(table, chain, plan, target.reshape((1, 4, 4)), seed.reshape((1, N_AXES)), q_out, info)


@workspace
def run_targets(table, chain, plan, targets, seeds, q_out, info):
    """Find the nearest branches for ``nearest_branches``."""
    n = targets.shape[0]
    step = 1 if n < _FEW else WIDTH
    rows, scratch = branch_state(1 if step == 1 else 2)
    best = best_state(plan)
    good = True
    for start in range(0, n, step):
        for lane in range(WIDTH):
            i = start if step == 1 else min(start + lane, n - 1)
            write_start_of(targets[i], seeds[min(i, seeds.shape[0] - 1)], rows[2], best[0], best[1], lane)
        if start == 0 or seeds.shape[0] > 1:
            write_free_angles(table, best[0], rows[1])
        write_branches(table, chain, 1 if step == 1 else 2, rows, scratch, best, with_bounds=True)
        best[3][:] = np.inf
        if polish_seed(table, chain, rows, scratch, (best[0], best[5], best[6]), step == 1):
            nearest_branch(best[5], best[6], best[0], best[1], best[2], best[3])
        nearest_branch(rows[3], rows[4], best[0], best[1], best[2], best[3])
        verify(chain, plan, rows[2], best[2], best[3], best[4])
        for lane in range(WIDTH if step > 1 else 1):
            i, chosen = min(start + lane, n - 1), lane if step > 1 else lowest_cost_lane(best[3])
            write_result((best[2], rows[2], best[4]), chosen, 0, i, q_out, info)
            if not (rigidity_defect(targets[i]) <= LARGEST_DEFECT and all_in_range(seeds[min(i, seeds.shape[0] - 1)])):
                info[i].status = NOT_A_POSE
            good &= info[i].status == SOLVED
    return good


@workspace
def best_state(plan):
    """Rows of the seeds, the bounds, the best branches, their costs, the state of a search, and polished seeds.

    The state is that of ``lane_state``. A polished seed has its q and its properties.
    """
    n_plan, cost, polished = plan.shape[0] - N_OPTIONS, 2 * N_AXES, 2 * N_AXES + 1 + N_STATE
    known = polished + N_AXES
    block = zero_rows(known + N_KNOWN + n_plan)
    bounds = block[known + N_KNOWN :]
    for k in range(n_plan):
        bounds[k, :] = plan[N_OPTIONS + k]
    return (
        block[:N_AXES],
        bounds,
        block[N_AXES:cost],
        block[cost : cost + 1],
        block[cost + 1 : polished],
        block[polished:known],
        block[known : known + N_KNOWN],
    )


@kernel
def write_start_of(target, seed, target_rows, seed_rows, bound_rows, lane):
    """Write a target and its seed, clipped to the bounds, to a lane."""
    write_target(matrix_pose(target), target_rows, lane)
    n = bound_rows.shape[0] // N_BOUNDS
    for j in range(n):
        seed_rows[j, lane] = min(max(seed[j], bound_rows[j, lane]), bound_rows[n + j, lane])


@kernel
def verify(chain, plan, target_rows, q_rows, cost_rows, state_rows):
    """Write the state of each lane: the errors by forward kinematics, and whether a branch is within the tolerances."""
    e = pose_error(chain_pose(chain, q_rows), load_pose(target_rows, 0))
    p2, r2 = error_squares(e)
    solved = (p2 <= plan[0] ** 2) & (r2 <= plan[1] ** 2) & (load(cost_rows, 0) < np.inf)
    store_state(state_rows, where(solved, HAS_SOLVED, HAS_FAILED), p2, r2, splat(0.0, p2), e)


@kernel
def lowest_cost_lane(cost_rows):
    """The lane with the minimum cost."""
    lane_of_minimum = 0
    for lane in range(1, WIDTH):
        if cost_rows[0, lane] < cost_rows[0, lane_of_minimum]:
            lane_of_minimum = lane
    return lane_of_minimum
