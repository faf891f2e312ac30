"""Solves damped least squares with bounds on each unknown, and computes the bounds of joint velocities.

It minimizes |J x - v|^2 + lambda |x|^2 with a lower and an upper bound on every x_j.

The method is a primal active-set method (Nocedal and Wright, Numerical Optimization, 2nd ed., algorithm 16.3). The active set
holds the entries that are fixed at a bound; the others are free. The problem is strictly convex, so it has one minimum.

1. Start at 0, clipped to the bounds.
2. Solve for the free entries, with the active ones fixed: x_f = J_f' (J_f J_f' + lambda I)^-1 (v - J_a x_a). If lambda is at most
   _LOST times the sum of squares of J, rounding in J_f J_f' would change it too much. Use singular values instead
   (``singular_values``). For fewer than six entries J_f J_f' is always singular, so the larger factor _LOST_OF_FEW replaces
   _LOST.
3. Move towards that solution until a free entry reaches a bound, the blocking entry. Add it to the active set; repeat from 2.
4. If no entry blocks, compute the derivative J_j' (J x - v) + lambda x_j of each active entry. Release the one that decreases
   fastest into the bounds; repeat from 2. If none decreases, x is the minimum.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import any_lane, load, splat, store, where
from ulna.kernels.ik.damped_system import add_column, column_dot, load_six, solve_damped, within_bounds
from ulna.kernels.ik.singular_values import damped_by_singular_values
from ulna.kernels.spatial.elementary import maximum, minimum

_ROUNDS = 4  # times the number of entries is the limit: each may enter and leave the active set more than once
_FLAT = 1e-12  # a smaller derivative counts as zero; with singular values, relative to the sum of its absolute terms
_LOST = 1e-8  # relative to the sum of squares of J: a smaller damping would lose more than 1e-7 of itself to rounding

_LOST_OF_FEW = 1e-4  # the same for fewer than six entries: nothing above 1e-11 is lost then, and singular values take little time


@routine
def bounded_least_squares(jacobian_rows, v_rows, damping, bound_rows, x_rows, scratch):
    """Write the minimum to x_rows.

    v_rows: Six. bound_rows: Lower, then upper bounds. damping: lambda, one number.
    """
    active_rows, goal_rows, _, _, _ = scratch
    n_dof = x_rows.shape[0]
    v = load_six(v_rows, 0)
    zero = splat(0.0, v[0])
    for j in range(n_dof):
        store(x_rows, j, within_bounds(zero, bound_rows, j))
        store(active_rows, j, where(load(bound_rows, j) < load(bound_rows, n_dof + j), zero, 1.0))
    squares = zero
    for i in range(6 * n_dof):
        squares = squares + load(jacobian_rows, i) * load(jacobian_rows, i)
    by_values = squares * (_LOST if n_dof >= 6 else _LOST_OF_FEW) >= damping
    running, rounds = zero + 1.0, 0
    while any_lane(running > 0.0) and rounds < _ROUNDS * n_dof + 1:
        rest = solve_free(jacobian_rows, v, damping, x_rows, scratch)
        residual = rest
        if any_lane(by_values):
            residual = solve_free_by_singular_values(rest, damping, by_values, x_rows, scratch)
        blocking = step_to_bound(bound_rows, x_rows, active_rows, goal_rows, running)
        settled = (blocking < 0.0) & (running > 0.0)
        if any_lane(settled):
            rows = bound_rows, x_rows, active_rows
            released = release_steepest(jacobian_rows, v, damping, rows, settled, by_values, residual)
            running = where(settled & (released < 0.0), 0.0, running)
        rounds += 1


@kernel
def solve_free(jacobian_rows, v, damping, x_rows, scratch):
    """Step 2: solve for the free entries. Returns v - J_a x_a, the right-hand side for them."""
    active_rows, goal_rows, free_rows, system_rows, _ = scratch
    for j in range(x_rows.shape[0]):
        active = load(active_rows, j) > 0.0
        v = add_column(v, jacobian_rows, j, where(active, -load(x_rows, j), 0.0))
        for k in range(6):
            store(free_rows, 6 * j + k, where(active, 0.0, load(jacobian_rows, 6 * j + k)))
    y = solve_damped(free_rows, x_rows.shape[0], splat(damping, v[0]), v, system_rows)
    for j in range(x_rows.shape[0]):
        goal = column_dot(free_rows, j, y)
        store(goal_rows, j, where(load(active_rows, j) > 0.0, load(x_rows, j), goal))
    return v


@kernel
def solve_free_by_singular_values(rest, damping, by_values, x_rows, scratch):
    """Step 2 by singular values, in the lanes of by_values; the residual v - J x. Overwrites the free rows."""
    n_dof, (active_rows, goal_rows, free_rows, _, rotated_rows) = x_rows.shape[0], scratch
    residual = damped_by_singular_values(free_rows, n_dof, splat(damping, rest[0]), rest, rotated_rows)
    shares = load_six(rotated_rows, 0)
    for j in range(n_dof):
        goal = where(load(active_rows, j) > 0.0, load(x_rows, j), column_dot(free_rows, j, shares))
        store(goal_rows, j, where(by_values, goal, load(goal_rows, j)))
    return residual


@kernel
def step_to_bound(bound_rows, x_rows, active_rows, goal_rows, running):
    """Step 3: move towards the goal until an entry reaches its bound. Returns the index of that entry, or -1."""
    n_dof = x_rows.shape[0]
    fraction, blocking = splat(2.0, running), splat(-1.0, running)
    for j in range(n_dof):
        x, goal, low, high = load(x_rows, j), load(goal_rows, j), load(bound_rows, j), load(bound_rows, n_dof + j)
        is_above, is_below = goal > high, goal < low
        step = where(is_above, high - x, where(is_below, x - low, 2.0)) / where(is_above | is_below, abs(goal - x), 1.0)
        shorter = step < fraction
        fraction, blocking = where(shorter, step, fraction), where(shorter, float(j), blocking)
    fraction = where(fraction < 1.0, fraction, 1.0)
    for j in range(n_dof):
        x, goal = load(x_rows, j), load(goal_rows, j)
        at_bound = (abs(blocking - j) < 0.5) & (running > 0.0)
        bound = where(goal > x, load(bound_rows, n_dof + j), load(bound_rows, j))
        moved = within_bounds(x + fraction * (goal - x), bound_rows, j)
        store(x_rows, j, where(running > 0.0, where(at_bound, bound, moved), x))
        store(active_rows, j, where(at_bound, 1.0, load(active_rows, j)))
    return blocking


@kernel
def release_steepest(jacobian_rows, v, damping, rows, settled, by_values, residual):
    """Step 4: release the active entry of steepest descent in settled lanes; its index, or -1 if none descends.

    rows: The bounds, x and the active set. residual: v - J x in the lanes that use singular values, with a small relative error.
    """
    bound_rows, x_rows, active_rows = rows
    n_dof = x_rows.shape[0]
    e = -v[0], -v[1], -v[2], -v[3], -v[4], -v[5]
    for j in range(n_dof):
        e = add_column(e, jacobian_rows, j, load(x_rows, j))
    e = negated_where(by_values, residual, e)
    max_gain, released = splat(0.0, v[0]), splat(-1.0, v[0])
    for j in range(n_dof):
        x, low, high = load(x_rows, j), load(bound_rows, j), load(bound_rows, n_dof + j)
        slope = column_dot(jacobian_rows, j, e) + damping * x
        gain = where((load(active_rows, j) > 0.0) & (low < high), where(x <= low, -slope, slope), 0.0)
        sizes = where(by_values, sizes_of_gradient(jacobian_rows, j, e) + damping * abs(x), 1.0)
        is_steeper = (gain > max_gain) & (gain > _FLAT * sizes)
        max_gain, released = where(is_steeper, gain, max_gain), where(is_steeper, float(j), released)
    for j in range(n_dof):
        store(active_rows, j, where(settled & (abs(released - j) < 0.5), 0.0, load(active_rows, j)))
    return released


@kernel
def negated_where(mask, a, b):
    """-a where the mask holds, b elsewhere: six numbers each."""
    return (
        where(mask, -a[0], b[0]), where(mask, -a[1], b[1]), where(mask, -a[2], b[2]),
        where(mask, -a[3], b[3]), where(mask, -a[4], b[4]), where(mask, -a[5], b[5]),
    )  # fmt: skip


@kernel
def sizes_of_gradient(jacobian_rows, j, e):
    """The sum of the absolute terms of entry j of J' e."""
    total = abs(load(jacobian_rows, 6 * j) * e[0])
    for k in range(1, 6):
        total = total + abs(load(jacobian_rows, 6 * j + k) * e[k])
    return total


@kernel
def velocity_bounds(limits, velocity_limits, dt, q_rows, bound_rows):
    """Write the lower and then the upper bounds of the joint velocities of one control step.

    They are the velocity limits, and the velocity that reaches the position limit at the end of the step, (limit - q) / dt. An
    entry beyond a limit returns at most at its velocity limit.
    """
    n_dof = velocity_limits.shape[0]
    for j in range(n_dof):
        q = load(q_rows, j)
        fast = splat(velocity_limits[j], q)
        store(bound_rows, j, minimum(maximum((limits[0, j] - q) / dt, -fast), fast))
        store(bound_rows, n_dof + j, minimum(maximum((limits[1, j] - q) / dt, -fast), fast))
