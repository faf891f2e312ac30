"""Takes of the branches of a closed form the one nearest to a seed within the joint limits. Used by ``drivers.closed_form``."""

import numpy as np

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import load, rint, store, where
from ulna.kernels.chain.closed_form_layout import AT_LIMIT, HARDLY_BEYOND, IS_WITHIN, N_KNOWN, REACHED, RESIDUAL
from ulna.kernels.spatial.elementary import maximum, minimum


@routine
def nearest_branch(q_rows, known_rows, seed_rows, bound_rows, best_rows, cost_rows):
    """For each lane the branch whose largest change of a joint is the least, whole turns made towards the seed.

    One that is written already stays where none has a smaller change.

    q_rows: six a branch; known_rows: N_KNOWN a branch; seed_rows: six, within the bounds; bound_rows: of each of the first n
    joints, the arm's own, the lower bounds, the upper ones, what a whole turn adds, and 1 over it; best_rows: six, written;
    cost_rows: one, changed: the largest change [rad or m], infinite where no branch is within.
    """
    n = bound_rows.shape[0] // 4
    for k in range(q_rows.shape[0] // 6):
        cost = where(load(known_rows, N_KNOWN * k + RESIDUAL) <= REACHED, 0.0, np.inf)
        for j in range(n):
            seed, q = load(seed_rows, j), load(q_rows, 6 * k + j)
            q, within = turned_towards(q, seed, bound_rows, j)
            store(q_rows, 6 * k + j, minimum(maximum(q, load(bound_rows, j)), load(bound_rows, n + j)))
            cost = maximum(cost, where(within, abs(q - seed), np.inf))
        better = cost < load(cost_rows, 0)
        store(cost_rows, 0, where(better, cost, load(cost_rows, 0)))
        for j in range(6):
            store(best_rows, j, where(better, load(q_rows, 6 * k + j), load(best_rows, j)))


@kernel
def turned_towards(q, seed, bound_rows, j):
    """q of joint j, whole turns made towards the seed within the bounds; and whether it is within them."""
    n = bound_rows.shape[0] // 4
    lower, upper, turn = load(bound_rows, j), load(bound_rows, n + j), load(bound_rows, 2 * n + j)
    q = q - turn * rint((q - seed) * load(bound_rows, 3 * n + j))
    q = where(q < lower - AT_LIMIT, q + turn, where(q > upper + AT_LIMIT, q - turn, q))
    return q, (q >= lower - AT_LIMIT) & (q <= upper + AT_LIMIT)


@routine
def hardly_beyond(q_rows, seed_rows, bound_rows, inside_rows):
    """Whether a branch is beyond the bounds, and no joint by more than HARDLY_BEYOND.

    inside_rows: six, written: the branch, turned towards the seed, with such joints at their bounds.
    """
    n = bound_rows.shape[0] // 4
    furthest = load(q_rows, 0) * 0.0
    for j in range(n):
        lower, upper, turn = load(bound_rows, j), load(bound_rows, n + j), load(bound_rows, 2 * n + j)
        q, within = turned_towards(load(q_rows, j), load(seed_rows, j), bound_rows, j)
        above = q > upper
        other = where(above, q - turn, q + turn)  # beyond the other bound
        by, by_other = where(above, q - upper, lower - q), where(above, lower - other, other - upper)
        q = where(within | (by <= by_other), q, other)
        furthest = maximum(furthest, where(within, 0.0, minimum(by, by_other)))
        store(inside_rows, j, minimum(maximum(q, lower), upper))
    for j in range(n, 6):
        store(inside_rows, j, load(q_rows, j))
    return (furthest > 0.0) & (furthest <= HARDLY_BEYOND)


@routine
def turn_within(q_rows, known_rows, branch, seed_rows, bound_rows):
    """Turn one branch towards the seed within the bounds, where it is real; its q is NaN elsewhere.

    q_rows: six, changed where the branch is within; known_rows: what is known of branches in one number, IS_WITHIN added.
    """
    n, known = bound_rows.shape[0] // 4, load(known_rows, branch)
    real = known - 2.0 * rint(0.5 * known - 0.25) > 0.0  # IS_REAL is the lowest bit
    all_within = real
    for j in range(n):
        q = load(q_rows, j)
        turned, within = turned_towards(q, load(seed_rows, j), bound_rows, j)
        store(q_rows, j, where(within, turned, q))
        all_within = all_within & within
    for j in range(n):
        q = load(q_rows, j)
        clipped = minimum(maximum(q, load(bound_rows, j)), load(bound_rows, n + j))
        store(q_rows, j, where(real, where(all_within, clipped, q), np.nan))
    store(known_rows, branch, known + where(all_within, IS_WITHIN * 1.0, 0.0))
