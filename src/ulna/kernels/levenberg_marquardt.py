"""Inverse kinematics: eight Levenberg-Marquardt searches for one target, one in each lane.

1. Eight starts: the caller's seed in lane 0, others from a table of random configurations within the limits.
2. Each step evaluates pose error and Jacobian, and moves by J' (J J' + lambda I)^-1 e with lambda = c |e|^2 + 1e-12
   (Sugihara, IEEE Trans. Robotics 2011), kept within the limits (``damped_step``).
3. After STEPS steps without success all lanes start anew, from the table's next eight.
4. As soon as a lane meets the tolerances it wins, and a few undamped steps polish it. If the caller gave a seed, lane 0 is
   given its whole first run before another lane may win, so that a path that is followed keeps its branch; then the
   nearest to the seed wins.
5. With a posture, in the first run, the part of (posture - q) that leaves the pose alone is added to each step, and a lane is
   done only when that part is used up (Liegeois 1977): dq = d + J' (J J' + lambda I)^-1 (e - J d), d = posture - q.
   The pose comes first: a run that ends at the pose with the posture not used up has succeeded, and where limits make both
   impossible the search begins again from the seed without a posture.
"""

import numpy as np

from ulna.kernels.compile import entry, kernel, routine
from ulna.kernels.damped_step import (
    N_SYSTEM,
    add_column,
    back_to_joints,
    error_squares,
    pose_error,
    release_pressed,
    solve_damped,
    within_limits,
)
from ulna.kernels.elementary import maximum
from ulna.kernels.jacobian import BASE, chain_jacobian
from ulna.kernels.lanes import WIDTH, any_lane, load, splat, store, where
from ulna.kernels.layout import COLUMN, FIXED, KIND, LARGEST_DEFECT
from ulna.kernels.se3 import matrix_pose, rigidity_defect
from ulna.kernels.search_layout import (
    ITERATIONS,
    MAX_ITERATIONS,
    NOT_A_POSE,
    NOT_FOUND,
    POSITION_ERROR,
    POSITION_TOLERANCE,
    ROTATION_ERROR,
    ROTATION_TOLERANCE,
    SEEDED,
    SOLVED,
    STATUS,
    WITH_POSTURE,
)

STEPS, SEEDED_STEPS = 20, 60
_DAMPING = 0.05
_LEAST_DAMPING = 1e-12
_POSTURE_SETTLED = 1e-8  # largest joint change of a step that has used up the posture
_POSTURE_STEP = 1.0  # rad: shorter ones settle too slowly, longer ones run in circles
_POLISHING_STEPS = 3


@kernel
def step(limits, posture, with_posture, e, damping, q_rows, scratch):
    """Move q by one damped step and return the largest change of a joint. J stands in the scratch, and is spoilt."""
    _, jacobian_rows, system_rows = scratch
    release_pressed(limits, q_rows, e, jacobian_rows)
    share = splat(0.0, damping)
    if with_posture:
        share = posture_share(posture, q_rows)
        e = without_posture(posture, share, q_rows, jacobian_rows, e)
    solve_damped(jacobian_rows, limits.shape[1], damping, e, system_rows)
    largest = splat(0.0, damping)
    for j in range(limits.shape[1]):
        q = load(q_rows, j)
        moved = q + back_to_joints(jacobian_rows, j, system_rows)
        if with_posture:
            moved = moved + share * (posture[j] - q)
        moved = within_limits(moved, limits, j)
        largest = maximum(largest, abs(moved - q))
        store(q_rows, j, moved)
    return largest


@kernel
def posture_share(posture, q_rows):
    """The share of the way to the posture that moves no joint by more than _POSTURE_STEP: the arm is not linear beyond."""
    largest = splat(_POSTURE_STEP, load(q_rows, 0))
    for j in range(posture.shape[0]):
        largest = maximum(largest, abs(posture[j] - load(q_rows, j)))
    return _POSTURE_STEP / largest


@kernel
def without_posture(posture, share, q_rows, jacobian_rows, e):
    """e - J d: what of the error remains once the joints have gone that share of the way to the posture."""
    for j in range(posture.shape[0]):
        e = add_column(e, jacobian_rows, j, share * (load(q_rows, j) - posture[j]))
    return e


@kernel
def evaluate(chain, target, q_rows, scratch):
    """The pose error at q and its two squares; J is left in the scratch."""
    axis_rows, jacobian_rows, _ = scratch
    e = pose_error(chain_jacobian(chain, q_rows, BASE, axis_rows, jacobian_rows), target)
    p2, r2 = error_squares(e)
    return e, p2, r2


@routine
def run_lanes(
    chain, limits, posture, with_posture, target, seed, settings, follow_seed, n_steps, q_rows, done_rows, error_rows, scratch
):
    """Steps 2 to 4 for eight starts in q_rows. Returns the lane that won, or -1, and the number of steps.

    The lanes end in q_rows, their squared errors in error_rows.
    """
    change = splat(np.inf if with_posture else 0.0, load(q_rows, 0))
    lane, k = -1, 0
    while True:
        e, p2, r2 = evaluate(chain, target, q_rows, scratch)
        near = (p2 <= settings[POSITION_TOLERANCE] ** 2) & (r2 <= settings[ROTATION_TOLERANCE] ** 2)
        done = near & (change <= _POSTURE_SETTLED)
        if k == n_steps:
            done = near  # the pose comes first: limits may keep the posture from being used up
        if any_lane(done) or k == n_steps:
            store(done_rows, 0, where(done, 1.0, 0.0))
            store(error_rows, 0, p2)
            store(error_rows, 1, r2)
            if k == n_steps or not follow_seed or done_rows[0, 0] != 0.0:
                lane = winner(done_rows, q_rows, seed, follow_seed)
                break
        moved = step(limits, posture, with_posture, e, (p2 + r2) * _DAMPING + _LEAST_DAMPING, q_rows, scratch)
        if with_posture:
            change = moved
        k += 1
    return lane, k


@kernel
def winner(done_rows, q_rows, seed, by_distance):
    """Among the lanes that are done, the first, or the one nearest to the seed (lane 0 before all); -1 if none is."""
    chosen, nearest = -1, np.inf
    for lane in range(WIDTH):
        distance = 0.0
        if by_distance and lane > 0:
            for j in range(seed.shape[0]):
                distance = max(distance, abs(q_rows[j, lane] - seed[j]))
        if done_rows[0, lane] != 0.0 and distance < nearest:
            chosen, nearest = lane, distance
    return chosen


@kernel
def least_error_lane(error_rows):
    """The lane of the smallest error."""
    lane = 0
    for k in range(1, WIDTH):
        if error_rows[0, k] + error_rows[1, k] < error_rows[0, lane] + error_rows[1, lane]:
            lane = k
    return lane


@routine
def polish(chain, limits, target, q, p2, r2, trial, scratch):
    """Undamped steps from q, each kept only if it lessens the error. Returns the squared errors."""
    copy(q, trial)
    e, _, _ = evaluate(chain, target, trial, scratch)
    for _ in range(_POLISHING_STEPS):
        step(limits, trial, False, e, _LEAST_DAMPING, trial, scratch)  # noqa: FBT003 - a kernel takes no keywords
        e, new_p2, new_r2 = evaluate(chain, target, trial, scratch)
        if not new_p2 + new_r2 < p2 + r2:
            break
        p2, r2 = new_p2, new_r2
        copy(trial, q)
    return p2, r2


@kernel
def copy(values, out):
    """Write values to out (a slice assignment would compile Numba's string formatting along, for seconds)."""
    for j in range(values.shape[0]):
        out[j] = values[j]


@kernel
def start_run(chain, starts, run, seed, from_seed, q_rows):
    """Put the table's next eight starts into the lanes, or the seed into lane 0.

    Joints that do not carry the link stay at the seed.
    """
    for j in range(seed.shape[0]):
        for lane in range(WIDTH):
            q_rows[j, lane] = seed[j]
    for i in range(chain.shape[0]):
        if int(chain[i, KIND]) != FIXED:
            j = int(chain[i, COLUMN])
            store(q_rows, j, load(starts[run], j))
            if from_seed:
                q_rows[j, 0] = seed[j]


@entry
def solve_each(chain, limits, starts, seeds, posture, targets, settings, q_out, info):
    """Solve for each target of shape (n, 4, 4); what is not solved leaves the best configuration met.

    limits: lower, upper (2, n_dof); starts: (runs, n_dof, 8), all within the limits; seeds: (n or 1, n_dof); q_out: (n, n_dof);
    info: (n, N_INFO) of search_layout.
    """
    n_dof, n_axes = limits.shape[1], 6 * chain.shape[0]
    q_rows, done_rows, error_rows = np.zeros((max(1, n_dof), WIDTH)), np.empty((1, WIDTH)), np.empty((2, WIDTH))
    scratch = np.empty((n_axes, WIDTH)), np.empty((6 * n_dof, WIDTH)), np.empty((N_SYSTEM, WIDTH))
    trial, scalar_scratch = np.empty(n_dof), (np.empty(n_axes), np.empty(6 * n_dof), np.empty(N_SYSTEM))
    for i in range(targets.shape[0]):
        if not rigidity_defect(targets[i]) <= LARGEST_DEFECT:
            info[i, STATUS] = NOT_A_POSE
            continue
        target, seed = matrix_pose(targets[i]), seeds[min(i, seeds.shape[0] - 1)]
        iterations, status, p2, r2 = 0, NOT_FOUND, np.inf, np.inf
        plain_run = 1 if settings[WITH_POSTURE] != 0.0 else 0  # the first without a posture
        for run in range(starts.shape[0]):
            from_seed = run <= plain_run
            start_run(chain, starts, run, seed, from_seed, q_rows)
            follow_seed = from_seed and settings[SEEDED] != 0.0
            patient = follow_seed or run < plain_run
            n_steps = min(SEEDED_STEPS if patient else STEPS, int(settings[MAX_ITERATIONS]) - iterations)
            lane, steps = run_lanes(
                chain, limits, posture, run < plain_run, target, seed, settings, follow_seed, n_steps,
                q_rows, done_rows, error_rows, scratch,
            )  # fmt: skip
            iterations += steps
            status = NOT_FOUND if lane < 0 else SOLVED
            if status == NOT_FOUND:
                lane = least_error_lane(error_rows)
            if status == SOLVED or error_rows[0, lane] + error_rows[1, lane] < p2 + r2:
                p2, r2 = error_rows[0, lane], error_rows[1, lane]
                for j in range(n_dof):
                    q_out[i, j] = q_rows[j, lane]
            if status == SOLVED or iterations >= settings[MAX_ITERATIONS]:
                break
        if status == SOLVED and settings[WITH_POSTURE] == 0.0:
            p2, r2 = polish(chain, limits, target, q_out[i], p2, r2, trial, scalar_scratch)
        info[i, STATUS], info[i, ITERATIONS] = status, iterations
        info[i, POSITION_ERROR], info[i, ROTATION_ERROR] = np.sqrt(p2), np.sqrt(r2)
