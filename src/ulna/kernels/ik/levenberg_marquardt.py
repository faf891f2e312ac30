"""Takes one Levenberg-Marquardt step of eight searches, one a lane.

Rows of a search (``rows``), all owned by the caller: q (n_dof); the previous q (n_dof); the target (12); the lower and then the
upper bounds (2 n_dof); the state, as numbered below.

1. Evaluate the pose error and the Jacobian at q, without the components that the task leaves free (``task``).
2. A lane is solved in two cases: its error is negligible; or it is within the tolerances, and another step no longer reduces its
   square by a factor of four. The better of the last two configurations is its result. A lane that uses up its steps before
   fails.
3. Every lane moves by J' (J J' + lambda I)^-1 e with lambda = c |e|^2 + 1e-12 (Sugihara, IEEE Trans. Robotics 2011), clipped to
   its bounds (``damped_system``). Further steps of an ended lane are ignored: its result is in the rows of the previous step. A
   ``calm`` search adds |e| to lambda. Near an unreachable target e does not vanish. The exact second derivative of |e|^2 / 2 then
   has a term that J J' lacks: the arm's curvature times e, about as large as |e|. Without |e| in lambda the steps would overshoot
   forever. |e|^2 counts no distance beyond ``max_square``. A prismatic joint is linear over any distance, so its steps need no
   damping, which would stall a long motion.
4. With a posture, each step adds the part of (posture - q) in the null space of J (Liegeois 1977). A lane is solved only when
   that part is used up. dq = d + J' (J J' + lambda I)^-1 (e - J d), d = posture - q. The pose comes first: a lane that uses up
   its steps at the pose has solved it.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import load, logical_not, splat, sqrt, store, where
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.ik.damped_system import (
    add_column,
    block_joints_at_bounds,
    column_dot,
    error_squares,
    pose_error,
    solve_damped,
    within_bounds,
)
from ulna.kernels.ik.search_layout import POINTING, WHOLE_POSE
from ulna.kernels.ik.task_error import task_error
from ulna.kernels.layout import IN_BASE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.se3 import load_pose

# Rows of the state. ENDED: RUNNING, or the outcome. LEAST: the squared error at the previous step if it was within the
# tolerances and no posture is given, else infinite. P2 and R2: the squares of the result's errors. TAKEN and ALLOWED: steps.
# CHANGE: the largest joint change in the last step, with a posture. From ERROR on: the result's pose error, six rows, in the
# base's axes, for any task.
ENDED, LAST_ERROR, P2, R2, TAKEN, ALLOWED, CHANGE, LAMBDA, ERROR = 0, 1, 2, 3, 4, 5, 6, 7, 8
N_STATE = ERROR + 6
RUNNING, HAS_SOLVED, HAS_FAILED = 0.0, 1.0, 2.0
_DAMPING = 0.05
_MIN_DAMPING = 1e-12
_NEGLIGIBLE = 1e-20  # of |e|^2: 0.1 nm
_WORTH_A_STEP = 0.25  # of |e|^2
_POSTURE_SETTLED = 1e-8  # largest joint change of a step after which the posture counts as used up
_POSTURE_STEP = 1.0  # rad: shorter steps converge too slowly, longer ones oscillate


@routine
def advance(chain, posture, settings, rows, scratch):
    """Steps 1 to 4 for all lanes; settings: a ``SearchSettings``."""
    q_rows, last_rows, target_rows, bound_rows, state_rows = rows
    jacobian_rows, system_rows = scratch
    target = load_pose(target_rows, 0)
    pose = chain_jacobian(chain, q_rows, IN_BASE, jacobian_rows, 6, 1)
    e = whole = pose_error(pose, target)
    if settings.task != WHOLE_POSE:
        e = task_error(settings.task == POINTING, settings.slack, pose, target, e, jacobian_rows)
    p2, r2 = error_squares(e)
    check_convergence(settings, p2, r2, whole, q_rows, last_rows, state_rows)
    block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows)
    if settings.max_square != 0.0:
        p2 = minimum(p2, settings.max_square)
    damping = (p2 + r2) * _DAMPING + sqrt(p2 + r2) * (1.0 if settings.calm else 0.0) + _MIN_DAMPING
    store(state_rows, LAMBDA, damping)
    if settings.with_posture:
        move_with_posture(posture, e, damping, rows, scratch)
    else:
        y = solve_damped(jacobian_rows, q_rows.shape[0], damping, e, system_rows)
        for j in range(q_rows.shape[0]):
            moved = load(q_rows, j) + column_dot(jacobian_rows, j, y)
            store(q_rows, j, within_bounds(moved, bound_rows, j))
    store(state_rows, TAKEN, load(state_rows, TAKEN) + 1.0)


@kernel
def check_convergence(settings, p2, r2, whole, q_rows, last_rows, state_rows):
    """Step 2: the outcome of each lane; the result so far is copied to the rows of the previous step."""
    total, last_total = p2 + r2, load(state_rows, LAST_ERROR)
    is_solved = (p2 <= settings.position_tolerance**2) & (r2 <= settings.rotation_tolerance**2)
    was_solved = last_total < np.inf
    is_reverted = was_solved & logical_not(is_solved & (total < last_total))
    is_enough = total <= _NEGLIGIBLE
    if settings.with_posture:
        is_enough = load(state_rows, CHANGE) <= _POSTURE_SETTLED
    settled = (was_solved & logical_not(is_solved & (total < _WORTH_A_STEP * last_total))) | (is_solved & is_enough)
    used_up = load(state_rows, TAKEN) >= load(state_rows, ALLOWED)
    solved = settled | (used_up & (is_solved | was_solved))
    store(state_rows, ENDED, where(solved, HAS_SOLVED, where(used_up, HAS_FAILED, RUNNING)))
    if not settings.with_posture:
        store(state_rows, LAST_ERROR, where(is_solved, total, np.inf))
    store(state_rows, P2, where(is_reverted, load(state_rows, P2), p2))
    store(state_rows, R2, where(is_reverted, load(state_rows, R2), r2))
    for k in range(6):
        store(state_rows, ERROR + k, where(is_reverted, load(state_rows, ERROR + k), whole[k]))
    for j in range(last_rows.shape[0]):
        store(last_rows, j, where(is_reverted, load(last_rows, j), load(q_rows, j)))


@kernel
def move_with_posture(posture, e, damping, rows, scratch):
    """Step 4; the largest joint change is stored in the state."""
    (q_rows, _, _, bound_rows, state_rows), (jacobian_rows, system_rows) = rows, scratch
    share = posture_share(posture, q_rows)
    rest = without_posture(posture, share, q_rows, jacobian_rows, e)
    y = solve_damped(jacobian_rows, q_rows.shape[0], damping, rest, system_rows)
    largest = splat(0.0, damping)
    for j in range(q_rows.shape[0]):
        q = load(q_rows, j)
        moved = q + column_dot(jacobian_rows, j, y) + share * (posture[j] - q)
        moved = within_bounds(moved, bound_rows, j)
        largest = maximum(largest, abs(moved - q))
        store(q_rows, j, moved)
    store(state_rows, CHANGE, largest)


@kernel
def posture_share(posture, q_rows):
    """The fraction of (posture - q) that moves no joint by more than _POSTURE_STEP: the arm is not linear beyond."""
    largest = splat(_POSTURE_STEP, load(q_rows, 0))
    for j in range(q_rows.shape[0]):
        largest = maximum(largest, abs(posture[j] - load(q_rows, j)))
    return _POSTURE_STEP / largest


@kernel
def without_posture(posture, share, q_rows, jacobian_rows, e):
    """e - J d: the error that remains after the joints have moved by that fraction of (posture - q)."""
    for j in range(q_rows.shape[0]):
        e = add_column(e, jacobian_rows, j, share * (load(q_rows, j) - posture[j]))
    return e
