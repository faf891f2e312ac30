"""Improves the branches of a closed form, and selects the branch nearest to a seed within the joint limits.

Newton steps of the forward kinematics improve a branch that nearly reaches its target:

1. Evaluate the pose error and the Jacobian at q.
2. Move by J' (J J' + lambda I)^-1 e with lambda = |e|^2 + 1e-13, which is Newton's step unless J has no inverse. Clip to the
   bounds, and leave out joints at a bound that would be pushed beyond it.
3. Keep the step of a lane if it reduces the error.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine, shared_routine
from ulna.engine.lanes import any_lane, load, rint, sqrt, store, where
from ulna.kernels.chain.closed_form_layout import AT_LIMIT, ENOUGH, HARDLY_BEYOND, IS_WITHIN, N_BOUNDS, N_KNOWN, REACHED, RESIDUAL
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import (
    block_joints_at_bounds,
    column_dot,
    error_squares,
    pose_error,
    solve_damped,
    within_bounds,
)
from ulna.kernels.layout import IN_BASE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.se3 import load_pose

_MIN_DAMPING = 1e-13


@routine
def nearest_branch(q_rows, known_rows, seed_rows, bound_rows, best_rows, cost_rows):
    """Select, for each lane, the branch with the smallest maximum joint change from the seed, up to whole turns.

    A branch already written stays unless another one has a smaller change.

    q_rows: Six rows a branch. known_rows: N_KNOWN a branch. seed_rows: Six, within the bounds. bound_rows: N_BOUNDS numbers for
    each of the first n joints, the arm's own: all lower bounds, all upper ones, the whole turns, their inverses, and the units
    for thresholds. A unit is 1 for an angle, and the reach for a prismatic joint [m]. best_rows: Six, output. cost_rows: One,
    updated: the largest change [rad or m], infinite without a branch within the bounds.
    """
    n = bound_rows.shape[0] // N_BOUNDS
    for k in range(q_rows.shape[0] // 6):
        cost = where(load(known_rows, N_KNOWN * k + RESIDUAL) <= REACHED, 0.0, np.inf)
        for j in range(n):
            seed, q = load(seed_rows, j), load(q_rows, 6 * k + j)
            q, within = turn_towards(q, seed, bound_rows, j)
            store(q_rows, 6 * k + j, minimum(maximum(q, load(bound_rows, j)), load(bound_rows, n + j)))
            cost = maximum(cost, where(within, abs(q - seed), np.inf))
        better = cost < load(cost_rows, 0)
        store(cost_rows, 0, where(better, cost, load(cost_rows, 0)))
        for j in range(6):
            store(best_rows, j, where(better, load(q_rows, 6 * k + j), load(best_rows, j)))


@kernel
def turn_towards(q, seed, bound_rows, j):
    """q of joint j with whole turns towards the seed within the bounds; and whether it is within them."""
    n = bound_rows.shape[0] // N_BOUNDS
    lower, upper, turn = load(bound_rows, j), load(bound_rows, n + j), load(bound_rows, 2 * n + j)
    at_limit = AT_LIMIT * load(bound_rows, 4 * n + j)
    q = q - turn * rint((q - seed) * load(bound_rows, 3 * n + j))
    q = where(q < lower - at_limit, q + turn, where(q > upper + at_limit, q - turn, q))
    return q, (q >= lower - at_limit) & (q <= upper + at_limit)


@routine
def is_any_hardly_beyond(q_rows, known_rows, bound_rows):
    """Whether ``is_hardly_beyond`` is true for any branch in any lane.

    q_rows: Six rows a branch. known_rows: N_KNOWN a branch.
    """
    n, is_any, bounded = bound_rows.shape[0] // N_BOUNDS, False, False
    for j in range(n):  # a joint that can make whole turns within its bounds is never beyond them
        bounded |= any_lane(load(bound_rows, n + j) - load(bound_rows, j) < load(bound_rows, 2 * n + j))
    if not bounded:
        return False
    for k in range(q_rows.shape[0] // 6):
        is_any |= any_lane(is_hardly_beyond(q_rows, known_rows, k, bound_rows))
    return is_any


@kernel
def is_hardly_beyond(q_rows, known_rows, k, bound_rows):
    """Whether branch k is real and beyond the bounds, up to whole turns, and no joint by more than HARDLY_BEYOND."""
    n, real = bound_rows.shape[0] // N_BOUNDS, load(known_rows, N_KNOWN * k + RESIDUAL) <= REACHED
    max_excess = where(real, 0.0, np.inf)
    for j in range(n):
        _, half, offset = offset_from_middle(load(q_rows, 6 * k + j), bound_rows, j)
        max_excess = maximum(max_excess, where(half < np.inf, abs(offset) - half, 0.0) / load(bound_rows, 4 * n + j))
        if not any_lane(max_excess <= HARDLY_BEYOND):
            break
    return (max_excess > AT_LIMIT) & (max_excess <= HARDLY_BEYOND)


@kernel
def offset_from_middle(q, bound_rows, j):
    """The middle of joint j's bounds, half their width, and q's offset from the middle, up to whole turns."""
    n = bound_rows.shape[0] // N_BOUNDS
    lower, upper = load(bound_rows, j), load(bound_rows, n + j)
    middle = 0.5 * (lower + upper)
    offset = q - middle
    return middle, 0.5 * (upper - lower), offset - load(bound_rows, 2 * n + j) * rint(offset * load(bound_rows, 3 * n + j))


@routine
def clip_branch(q_rows, seed_rows, bound_rows, inside_rows):
    """Write a branch with whole turns towards the seed; joints beyond their bounds are put at the nearest bound.

    All arguments have six rows.
    """
    n = bound_rows.shape[0] // N_BOUNDS
    for j in range(6):
        q = load(q_rows, j)
        if j < n:
            turned, within = turn_towards(q, load(seed_rows, j), bound_rows, j)
            middle, half, offset = offset_from_middle(q, bound_rows, j)
            q = where(within, turned, middle + minimum(maximum(offset, -half), half))
            q = minimum(maximum(q, load(bound_rows, j)), load(bound_rows, n + j))
        store(inside_rows, j, q)


@routine
def turn_within(q_rows, known_rows, branch, seed_rows, bound_rows):
    """Bring a real branch towards the seed by whole turns within the bounds; other branches become NaN.

    q_rows: Six, changed where the branch is within the bounds. known_rows: Flags of the branches, one number each; IS_WITHIN is
    added.
    """
    n, known = bound_rows.shape[0] // N_BOUNDS, load(known_rows, branch)
    real = known - 2.0 * rint(0.5 * known - 0.25) > 0.0  # IS_REAL is the lowest bit
    all_within = real
    for j in range(n):
        q = load(q_rows, j)
        turned, within = turn_towards(q, load(seed_rows, j), bound_rows, j)
        store(q_rows, j, where(within, turned, q))
        all_within = all_within & within
    for j in range(n):
        q = load(q_rows, j)
        clipped = minimum(maximum(q, load(bound_rows, j)), load(bound_rows, n + j))
        store(q_rows, j, where(real, where(all_within, clipped, q), np.nan))
    store(known_rows, branch, known + where(all_within, IS_WITHIN * 1.0, 0.0))


@shared_routine
def polish(chain, rows, inverse_reach, most, steps, scratch):
    """Take at most ``steps`` Newton steps in the lanes whose error is above ENOUGH and at most ``most``.

    rows: The target, twelve; q (n_dof), updated; the error, one (shares of the reach and radians, in one square root), updated;
    the lower bounds of the first joints, then the upper ones; the others are unbounded. scratch: (6 n_dof), (N_SYSTEM), (n_dof).
    """
    (target_rows, q_rows, error_rows, bound_rows), (jacobian_rows, system_rows, last_rows) = rows, scratch
    n_dof, n_bounded, target = q_rows.shape[0], bound_rows.shape[0] // 2, load_pose(target_rows, 0)
    for _ in range(steps):
        error = load(error_rows, 0)
        moving = (error > ENOUGH) & (error <= most)
        if not any_lane(moving):
            return
        e = pose_error(chain_jacobian(chain, q_rows, IN_BASE, jacobian_rows, 6, 1), target)
        p2, r2 = error_squares(e)
        before = sqrt(p2 * inverse_reach**2 + r2)
        block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows)
        y = solve_damped(jacobian_rows, n_dof, p2 + r2 + _MIN_DAMPING, e, system_rows)
        for j in range(n_dof):
            q = load(q_rows, j)
            store(last_rows, j, q)
            store(q_rows, j, q + column_dot(jacobian_rows, j, y))
        for j in range(n_bounded):
            store(q_rows, j, within_bounds(load(q_rows, j), bound_rows, j))
        p2, r2 = error_squares(pose_error(chain_pose(chain, q_rows), target))
        after = sqrt(p2 * inverse_reach**2 + r2)
        better = moving & (after < before)
        for j in range(n_dof):
            store(q_rows, j, where(better, load(q_rows, j), load(last_rows, j)))
        store(error_rows, 0, where(better, after, where(moving, before, error)))
