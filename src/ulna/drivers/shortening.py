"""Shortens a path of free edges."""

from ulna.drivers.planned_edge import is_free
from ulna.engine.decorators import kernel, routine
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import distance, write_step

N_ATTEMPTS = 48  # of pass 2
LEAVE_OUT = 4  # the pass
N_HALVINGS = 3  # how near to a corner its cut may be: at 1/2, 1/4, 1/8 of its edges
WORTH_A_CUT = 1e-3  # of the length of a path: what gains less is not tried
_FIRST_SHARE, _SECOND_SHARE = 0.7548776662466927, 0.5698402909980532  # of the plastic number: Roberts's sequence R2 (2018)


@routine
def shorten_path(edges, path, known, spreads, ends, state):
    """Shorten a path in place until nothing is gained, or state[UNTIL] edges were checked.

    path: (capacity, n_dof), of which state[POINTS] are its points; known: 1 where the edge from a point was found free as it
    is, else 0, shape (1, capacity). Returns SOLVED, PAUSED or NOT_FREE. The passes:

    1. From each point in turn, go straight to the farthest point that a free edge reaches (Geraerts and Overmars, Creating
       high-quality paths for motion planning, IJRR 2007).
    2. The same between places at shares of the length given by a low-discrepancy sequence.
    3. Cut each corner: between the middles of its two edges, or nearer to it, if that edge is free. What is left of the two edges
       is part of what was free. Twice.
    4. Leave out each point without which the edge is free.
    5. Confirm every edge of the path that was not found free as it is now. Returns NOT_FREE if one is not free.
    """
    while state[layout.CHECKS] < state[layout.UNTIL]:
        if state[layout.PASS] == layout.CONFIRM:
            if state[layout.AT] >= state[layout.POINTS] - 1:
                return layout.SOLVED
            if not confirms(edges, path, known, spreads, state):
                return layout.NOT_FREE
        elif not goes_on(edges, path, known, ends, state):
            state[layout.AT], state[layout.OTHER] = 0, 0
            state[layout.PASS] += 1
    return layout.PAUSED


@kernel
def goes_on(edges, path, known, ends, state):
    """One edge of the pass; whether the pass goes on."""
    if state[layout.PASS] == 0:
        return jump(edges, path, known, state)
    if state[layout.PASS] == 1:
        return short_cut(edges, path, known, ends, state)
    if state[layout.PASS] < LEAVE_OUT:
        return cut_corner(edges, path, known, ends, state)
    return leave_out(edges, path, known, state)


@kernel
def confirms(edges, path, known, spreads, state):
    """Whether the next edge of the path, or what lies within its spread, is free, one way or the other."""
    i = state[layout.AT]
    state[layout.AT] += 1
    if known[0, i] == 1 and spreads.shape[0] == 0:
        return True
    state[layout.CHECKS] += 1
    spread = spreads[i] if spreads.shape[0] > 0 else edges.no_spread
    return is_free(edges, path[i], path[i + 1], spread) or is_free(edges, path[i + 1], path[i], spread)


@kernel
def jump(edges, path, known, state):
    """One edge of pass 1; whether the pass goes on."""
    n, i = state[layout.POINTS], state[layout.AT]
    if i >= n - 2:
        return False
    j = n - 1 if state[layout.OTHER] == 0 else state[layout.OTHER]
    state[layout.CHECKS] += 1
    if is_free(edges, path[i], path[j], edges.no_spread):
        replace_points(path, known, state, i + 1, j, 0)
        known[0, i], j = 1, i + 1
    state[layout.OTHER] = j - 1
    if j - 1 <= i + 1:
        state[layout.AT], state[layout.OTHER] = i + 1, 0
    return True


@kernel
def leave_out(edges, path, known, state):
    """One edge of pass 4; whether the pass goes on."""
    i = state[layout.AT]
    if i >= state[layout.POINTS] - 2:
        return False
    state[layout.CHECKS] += 1
    if is_free(edges, path[i], path[i + 2], edges.no_spread):
        replace_points(path, known, state, i + 1, i + 2, 0)
        known[0, i] = 1
    else:
        state[layout.AT] += 1
    return True


@kernel
def short_cut(edges, path, known, ends, state):
    """One attempt of pass 2; whether the pass goes on."""
    n, attempt, space = state[layout.POINTS], state[layout.AT], edges.space
    if n < 3 or attempt >= N_ATTEMPTS or n + 2 > path.shape[0]:
        return False
    state[layout.AT] += 1
    total = length_of(path, n, space)
    x, y = (0.5 + attempt * _FIRST_SHARE) % 1.0, (0.5 + attempt * _SECOND_SHARE) % 1.0
    i, before = write_place(path, n, min(x, y) * total, space, ends[0])
    j, after = write_place(path, n, max(x, y) * total, space, ends[1])
    if i == j or distance(ends[0], ends[1], space) > after - before - WORTH_A_CUT * total:
        return True
    state[layout.CHECKS] += 1
    if is_free(edges, ends[0], ends[1], edges.no_spread):
        replace_points(path, known, state, i + 1, j + 1, 2)
        write_point(path, i + 1, ends[0])
        write_point(path, i + 2, ends[1])
        known[0, i + 1] = 1
    return True


@kernel
def cut_corner(edges, path, known, ends, state):
    """One edge of pass 3; whether the pass goes on."""
    n, i, space = state[layout.POINTS], state[layout.AT] + 1, edges.space
    if i >= n - 1 or n + 1 > path.shape[0]:
        return False
    share = 0.5 / (1 << state[layout.OTHER])  # a power would call exp2, which is not in the wheel
    write_step(path[i], path[i - 1], share, space, ends[0])
    write_step(path[i], path[i + 1], share, space, ends[1])
    around = share * (distance(path[i - 1], path[i], space) + distance(path[i], path[i + 1], space))
    if around - distance(ends[0], ends[1], space) < WORTH_A_CUT * length_of(path, n, space):
        state[layout.AT], state[layout.OTHER] = i, 0
        return True
    state[layout.CHECKS] += 1
    if is_free(edges, ends[0], ends[1], edges.no_spread):
        replace_points(path, known, state, i, i + 1, 2)
        write_point(path, i, ends[0])
        write_point(path, i + 1, ends[1])
        known[0, i] = 1
        state[layout.AT], state[layout.OTHER] = i + 1, 0
    elif state[layout.OTHER] + 1 < N_HALVINGS:
        state[layout.OTHER] += 1
    else:
        state[layout.AT], state[layout.OTHER] = i, 0
    return True


@routine
def replace_points(path, known, state, i, j, n_new):
    """Make room for n_new points in place of the points i to j - 1 of a path, i > 0; of the new edges none is known."""
    n, shift = state[layout.POINTS], n_new - (j - i)
    for m in range(n - j):
        source = n - 1 - m if shift > 0 else j + m
        for k in range(path.shape[1]):
            path[source + shift, k] = path[source, k]
        known[0, source + shift] = known[0, source]
    for m in range(i - 1, i + n_new):
        known[0, m] = 0
    state[layout.POINTS] = n + shift


@routine
def write_point(path, i, q):
    """Write a configuration to place i of a path."""
    for k in range(path.shape[1]):
        path[i, k] = q[k]


@routine
def length_of(path, n, space):
    """The length of the first n points of a path."""
    total = 0.0
    for i in range(n - 1):
        total += distance(path[i], path[i + 1], space)
    return total


@routine
def write_place(path, n, at, space, q):
    """Write the configuration at a length of a path to q; the edge on which it lies, and its length from the start."""
    done = 0.0
    for i in range(n - 1):
        step = distance(path[i], path[i + 1], space)
        if at <= done + step or i == n - 2:
            write_step(path[i], path[i + 1], min(1.0, (at - done) / step) if step > 0.0 else 0.0, space, q)
            return i, at
        done += step
    return 0, 0.0
