"""Solves damped least squares with bounds on each unknown. Used by ``drivers.differential_ik``.

It finds the x that minimises |J x - v|^2 + lambda |x|^2 with every x_j between two numbers.

A primal active-set method (Nocedal and Wright, Numerical Optimization, 2nd ed., algorithm 16.3); the problem is strictly convex,
so what it ends at is the only minimum.

1. Begin at 0, or the nearest to it within the bounds.
2. Hold the entries that stand at a bound, and solve for the others alone: x_f = J_f' (J_f J_f' + lambda I)^-1 (v - J_h x_h).
   Where lambda is at most LOST of the squares of J, to which it is added, by singular values instead (``singular_values``).
3. Go towards that solution until an entry meets its bound; hold that entry there too, and repeat from 2.
4. If none does, look at the held ones: one whose derivative J_j' (J x - v) + lambda x_j leads back inside is let go, the steepest
   first. If there is none, this is the minimum.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import any_lane, load, splat, store, where
from ulna.kernels.ik.damped_step import add_column, back_to_joints, gradient, solve_damped, within_bounds
from ulna.kernels.ik.singular_values import damped_by_singular_values, sum_of_rows

_ROUNDS = 4  # an entry, at most: each may be held and let go more than once
_FLAT = 1e-12  # of a derivative: below it nothing is gained by letting go; by singular values, of the sizes of its terms
_LOST = 1e-8  # of all squares of J: a damping below it would be off by more than 1e-7 of itself


@routine
def bounded_least_squares(jacobian_rows, v_rows, damping, bound_rows, x_rows, scratch):
    """Write the minimum to x_rows. v_rows: six; bound_rows: lower, then upper bounds; damping: lambda, a plain number."""
    held_rows, goal_rows, free_rows, system_rows, turned_rows = scratch
    n_dof = x_rows.shape[0]
    v = load(v_rows, 0), load(v_rows, 1), load(v_rows, 2), load(v_rows, 3), load(v_rows, 4), load(v_rows, 5)
    zero = splat(0.0, v[0])
    for j in range(n_dof):
        store(x_rows, j, within_bounds(zero, bound_rows, j))
        store(held_rows, j, where(load(bound_rows, j) < load(bound_rows, n_dof + j), zero, 1.0))
    squares = zero
    for i in range(6 * n_dof):
        squares = squares + load(jacobian_rows, i) * load(jacobian_rows, i)
    by_values = squares * _LOST >= damping
    running, rounds = zero + 1.0, 0
    while any_lane(running > 0.0) and rounds < _ROUNDS * n_dof + 1:
        rest = aim(jacobian_rows, v, damping, x_rows, held_rows, goal_rows, free_rows, system_rows)
        residual = rest
        if any_lane(by_values):
            residual = aim_by_values(rest, damping, by_values, x_rows, held_rows, goal_rows, free_rows, turned_rows)
        met = approach(bound_rows, x_rows, held_rows, goal_rows, running)
        settled = (met < 0.0) & (running > 0.0)
        if any_lane(settled):
            let_go = release(jacobian_rows, v, damping, bound_rows, x_rows, held_rows, settled, by_values, residual)
            running = where(settled & (let_go < 0.0), 0.0, running)
        rounds += 1


@kernel
def aim(jacobian_rows, v, damping, x_rows, held_rows, goal_rows, free_rows, system_rows):
    """Step 2: the solution with the held entries where they are. Returns v - J_h x_h, what the others are to give."""
    for j in range(x_rows.shape[0]):
        held = load(held_rows, j) > 0.0
        v = add_column(v, jacobian_rows, j, where(held, -load(x_rows, j), 0.0))
        for k in range(6):
            store(free_rows, 6 * j + k, where(held, 0.0, load(jacobian_rows, 6 * j + k)))
    solve_damped(free_rows, x_rows.shape[0], splat(damping, v[0]), v, system_rows)
    for j in range(x_rows.shape[0]):
        goal = back_to_joints(free_rows, j, system_rows)
        store(goal_rows, j, where(load(held_rows, j) > 0.0, load(x_rows, j), goal))
    return v


@kernel
def aim_by_values(rest, damping, by_values, x_rows, held_rows, goal_rows, free_rows, turned_rows):
    """Step 2 by singular values, where they are asked for. Returns v - J x at the solution; spoils free_rows."""
    n_dof = x_rows.shape[0]
    residual = damped_by_singular_values(free_rows, n_dof, splat(damping, rest[0]), rest, turned_rows)
    for j in range(n_dof):
        goal = where(load(held_rows, j) > 0.0, load(x_rows, j), sum_of_rows(free_rows, j, turned_rows))
        store(goal_rows, j, where(by_values, goal, load(goal_rows, j)))
    return residual


@kernel
def approach(bound_rows, x_rows, held_rows, goal_rows, running):
    """Step 3: go towards the goal until an entry meets its bound; its number, or -1 where none does."""
    n_dof = x_rows.shape[0]
    share, met = splat(2.0, running), splat(-1.0, running)
    for j in range(n_dof):
        x, goal, low, high = load(x_rows, j), load(goal_rows, j), load(bound_rows, j), load(bound_rows, n_dof + j)
        over, under = goal > high, goal < low
        room = where(over, high - x, where(under, x - low, 2.0)) / where(over | under, abs(goal - x), 1.0)
        sooner = room < share
        share, met = where(sooner, room, share), where(sooner, float(j), met)
    share = where(share < 1.0, share, 1.0)
    for j in range(n_dof):
        x, goal = load(x_rows, j), load(goal_rows, j)
        at_bound = (abs(met - j) < 0.5) & (running > 0.0)
        bound = where(goal > x, load(bound_rows, n_dof + j), load(bound_rows, j))
        moved = within_bounds(x + share * (goal - x), bound_rows, j)
        store(x_rows, j, where(running > 0.0, where(at_bound, bound, moved), x))
        store(held_rows, j, where(at_bound, 1.0, load(held_rows, j)))
    return met


@kernel
def release(jacobian_rows, v, damping, bound_rows, x_rows, held_rows, settled, by_values, residual):
    """Step 4: let go the held entry that gains most, where a lane has settled; its number, or -1 where none gains.

    residual: v - J x where x is by singular values, as exact as lambda x, of whose size it may be.
    """
    n_dof = x_rows.shape[0]
    e = -v[0], -v[1], -v[2], -v[3], -v[4], -v[5]
    for j in range(n_dof):
        e = add_column(e, jacobian_rows, j, load(x_rows, j))
    e = minus_where(by_values, residual, e)
    most, let_go = splat(0.0, v[0]), splat(-1.0, v[0])
    for j in range(n_dof):
        x, low, high = load(x_rows, j), load(bound_rows, j), load(bound_rows, n_dof + j)
        slope = gradient(jacobian_rows, j, e) + damping * x
        gain = where((load(held_rows, j) > 0.0) & (low < high), where(x <= low, -slope, slope), 0.0)
        sizes = where(by_values, sizes_of_gradient(jacobian_rows, j, e) + damping * abs(x), 1.0)
        better = (gain > most) & (gain > _FLAT * sizes)
        most, let_go = where(better, gain, most), where(better, float(j), let_go)
    for j in range(n_dof):
        store(held_rows, j, where(settled & (abs(let_go - j) < 0.5), 0.0, load(held_rows, j)))
    return let_go


@kernel
def minus_where(mask, a, b):
    """-a where the mask holds, b elsewhere: six numbers each."""
    return (
        where(mask, -a[0], b[0]), where(mask, -a[1], b[1]), where(mask, -a[2], b[2]),
        where(mask, -a[3], b[3]), where(mask, -a[4], b[4]), where(mask, -a[5], b[5]),
    )  # fmt: skip


@kernel
def sizes_of_gradient(jacobian_rows, j, e):
    """The terms of entry j of J' e, added up regardless of their signs."""
    total = abs(load(jacobian_rows, 6 * j) * e[0])
    for k in range(1, 6):
        total = total + abs(load(jacobian_rows, 6 * j + k) * e[k])
    return total
