"""Takes of the branches of a closed form the one nearest to a seed within the joint limits. Used by ``drivers.closed_form``."""

import numpy as np

from ulna.engine.decorators import routine
from ulna.engine.lanes import load, rint, splat, store, where
from ulna.kernels.chain.closed_form_layout import N_KNOWN, REACHED, RESIDUAL
from ulna.kernels.spatial.elementary import maximum, minimum

AT_LIMIT = 1e-9  # rad or m: no further beyond a limit than this, a joint is at it


@routine
def nearest_branch(q_rows, known_rows, seed_rows, bound_rows, best_rows, cost_rows):
    """For each lane the branch whose largest change of a joint is the least, whole turns made towards the seed.

    q_rows: six a branch; known_rows: N_KNOWN a branch; seed_rows: six, within the bounds; bound_rows: of each of the first n
    joints, the arm's own, the lower bounds, the upper ones, what a whole turn adds, and 1 over it; best_rows: six, written;
    cost_rows: one, written: the largest change [rad or m], infinite where no branch is within.
    """
    like, n = load(seed_rows, 0), bound_rows.shape[0] // 4
    store(cost_rows, 0, splat(np.inf, like))
    for k in range(q_rows.shape[0] // 6):
        cost = where(load(known_rows, N_KNOWN * k + RESIDUAL) <= REACHED, 0.0, np.inf)
        for j in range(n):
            lower, upper, turn = load(bound_rows, j), load(bound_rows, n + j), load(bound_rows, 2 * n + j)
            q, seed = load(q_rows, 6 * k + j), load(seed_rows, j)
            q = q - turn * rint((q - seed) * load(bound_rows, 3 * n + j))
            q = where(q < lower - AT_LIMIT, q + turn, where(q > upper + AT_LIMIT, q - turn, q))
            within = (q >= lower - AT_LIMIT) & (q <= upper + AT_LIMIT)
            store(q_rows, 6 * k + j, minimum(maximum(q, lower), upper))
            cost = maximum(cost, where(within, abs(q - seed), np.inf))
        better = cost < load(cost_rows, 0)
        store(cost_rows, 0, where(better, cost, load(cost_rows, 0)))
        for j in range(6):
            store(best_rows, j, where(better, load(q_rows, 6 * k + j), load(best_rows, j)))
