"""Shortens a path of free edges."""

from typing import NamedTuple

from numpy.typing import NDArray

from ulna.engine.decorators import kernel, routine
from ulna.kernels.planning.space import distance, write_step
from ulna.planning.entries.edge import is_free
from ulna.planning.entries.extension import gains_little, write_curve
from ulna.planning.search_records import BESIDE, CONFIRM, NOT_FREE, PAUSED, REACHED, SOLVED, STOPPED

N_ATTEMPTS = 48  # of pass 2
N_FAILURES = 8  # in a row end it, with constraints
LEAVE_OUT = 4  # the pass
N_HALVINGS = 3  # how near to a corner its cut may be: at 1/2, 1/4, 1/8 of its edges
WORTH_A_CUT = 1e-3  # of the length of a path: what gains less is not tried
_FIRST_SHARE, _SECOND_SHARE = 0.7548776662466927, 0.5698402909980532  # of the plastic number: Roberts's sequence R2 (2018)


class Cut(NamedTuple):
    """Room for a short cut, shape (n_dof,) each."""

    first: NDArray
    """Where it begins."""
    second: NDArray
    """Where it ends."""
    at: NDArray
    """Along constraints: where a step of it begins."""
    new: NDArray
    """And where it ends."""


@routine
def shorten_path(context, path, cut, state):
    """Shorten a path in place until nothing is gained, or ``state.until`` edges were checked.

    Of its waypoints ``state.points`` are in use. Returns SOLVED, PAUSED or NOT_FREE. The passes:

    1. From each point in turn, go straight to the farthest point that a free edge reaches (Geraerts and Overmars, Creating
       high-quality paths for motion planning, IJRR 2007).
    2. Go straight between places at shares of the length given by a low-discrepancy sequence; with constraints along them,
       without pass 1.
    3. Cut each corner: between the middles of its two edges, or nearer to it, if that edge is free. What is left of the two edges
       is part of what was free. Twice.
    4. Leave out each point without which the edge is free.
    5. Confirm every edge of the path that was not found free as it is now. Returns NOT_FREE if one is not free.
    """
    while state.checks < state.until:
        if state.stage == CONFIRM:
            if state.at >= state.points - 1:
                return SOLVED
            if not confirms(context, path, state):
                return NOT_FREE
        elif not goes_on(context, path, cut, state):
            state.at = state.target = state.failures = state.halvings = 0
            state.stage += 1
    return PAUSED


@kernel
def goes_on(context, path, cut, state):
    """One edge of the pass; whether the pass goes on."""
    if state.stage == 0:
        return context.keeping is None and jump(context, path, state)
    if state.stage == 1:
        return short_cut(context, path, cut, state)
    if state.stage < LEAVE_OUT:
        return cut_corner(context, path, cut, state)
    return leave_out(context, path, state)


@kernel
def is_open(context, q_a, q_b, state):
    """Count an edge; whether it is free."""
    state.checks += 1
    return is_free(context, q_a, q_b, context.no_spread)


@kernel
def confirms(context, path, state):
    """Whether the next edge of the path, or what lies within its spread, is free, one way or the other."""
    i, points, spreads = state.at, path.waypoints, path.spreads
    state.at += 1
    if path.known[i] == 1:
        return True
    state.checks += 1
    spread = spreads[i] if spreads.shape[0] > 0 else context.no_spread
    return is_free(context, points[i], points[i + 1], spread) or is_free(context, points[i + 1], points[i], spread)


@kernel
def jump(context, path, state):
    """One edge of pass 1; whether the pass goes on."""
    n, i = state.points, state.at
    if i >= n - 2:
        return False
    j = n - 1 if state.target == 0 else state.target
    if is_open(context, path.waypoints[i], path.waypoints[j], state):
        replace_points(path, state, i + 1, j, 0)
        path.known[i], j = 1, i + 1
    state.target = j - 1
    if j - 1 <= i + 1:
        state.at, state.target = i + 1, 0
    return True


@kernel
def leave_out(context, path, state):
    """One edge of pass 4; whether the pass goes on."""
    i = state.at
    if i >= state.points - 2:
        return False
    if is_open(context, path.waypoints[i], path.waypoints[i + 2], state):
        replace_points(path, state, i + 1, i + 2, 0)
        path.known[i] = 1
    else:
        state.at += 1
    return True


@kernel
def short_cut(context, path, cut, state):
    """One attempt of pass 2; whether the pass goes on."""
    points, n, attempt, space = path.waypoints, state.points, state.at, context.space
    if n < 3 or attempt >= N_ATTEMPTS or n + 2 > state.capacity:
        return False
    state.at += 1
    total = length_of(points, n, space)
    x, y = (0.5 + attempt * _FIRST_SHARE) % 1.0, (0.5 + attempt * _SECOND_SHARE) % 1.0
    i, before = write_place(points, n, min(x, y) * total, space, cut.first)
    j, after = write_place(points, n, max(x, y) * total, space, cut.second)
    most = after - before - WORTH_A_CUT * total
    if i == j or distance(cut.first, cut.second, space) > most:
        return True
    return short_cut_by(context.keeping, context, path, (i, j), cut, most, state)


@kernel
def short_cut_by(keeping, context, path, edges, cut, most, state):
    """The edge of a short cut between two places on edges, or with constraints the edges; whether the pass goes on."""
    i, j = edges
    points = path.waypoints
    if keeping is not None:
        return short_cut_along(context, path, i, j, cut, most, state)
    if is_open(context, cut.first, cut.second, state):
        replace_points(path, state, i + 1, j + 1, 2)
        write_point(points, i + 1, cut.first)
        write_point(points, i + 2, cut.second)
        path.known[i + 1] = 1
    return True


@routine
def short_cut_along(context, path, i, j, cut, most, state):
    """Make a short cut between two places on edges i and j, along the constraints, if it is not longer than ``most``.

    The pass ends after N_FAILURES in a row: one that leads along constraints takes as many edges as a part of the path has.
    """
    points, last = path.waypoints, path.waypoints.shape[0] - 1
    n = write_detour(context, path, cut, most, state)
    state.failures = 0 if n > 0 else state.failures + 1
    if n > 0:
        replace_points(path, state, i + 1, j + 1, n + 1)
        write_point(points, i + 1, cut.first)
        for m in range(n):
            write_point(points, i + 2 + m, points[last - m])
            path.known[i + 1 + m] = 1
    return state.failures < N_FAILURES


@routine
def write_detour(context, path, cut, most, state):
    """Write the corners of a way from cut.first to cut.second along the constraints to the last rows of a path; how many.

    From the last row on backwards. Without cut.first; 0 if there is no way, or it is longer than ``most``, or there is no room.
    """
    space, points, curve, at, new, n, way = context.space, path.waypoints, context.keeping.curve, cut.at, cut.new, 0, 0.0
    for k in range(at.shape[0]):
        at[k] = cut.first[k]
    while True:
        left = distance(at, cut.second, space)
        share = min(1.0, context.settings.stride / left)
        write_step(at, cut.second, share, space, new)
        n_more, end = write_curve(context, at, new, state)
        if end == STOPPED or state.points + 2 * (n + n_more + 1) > state.capacity:
            return 0
        for m in range(n_more):
            way += distance(at, curve[m], space)
            write_point(points, points.shape[0] - 1 - n, curve[m])
            n += 1
            for k in range(at.shape[0]):
                at[k] = curve[m, k]
        after = distance(at, cut.second, space)
        if way + after > most or (end == BESIDE and gains_little(at, cut.second, left, share, space)):
            return 0
        if share == 1.0 and end == REACHED:
            return n


@kernel
def cut_corner(context, path, cut, state):
    """One edge of pass 3; whether the pass goes on."""
    points, n, i, space = path.waypoints, state.points, state.at + 1, context.space
    if i >= n - 1 or n + 1 > state.capacity:
        return False
    share = 0.5 / (1 << state.halvings)  # a power would call exp2, which is not in the wheel
    write_step(points[i], points[i - 1], share, space, cut.first)
    write_step(points[i], points[i + 1], share, space, cut.second)
    around = share * (distance(points[i - 1], points[i], space) + distance(points[i], points[i + 1], space))
    if around - distance(cut.first, cut.second, space) < WORTH_A_CUT * length_of(points, n, space):
        state.at, state.halvings = i, 0
        return True
    if is_open(context, cut.first, cut.second, state):
        replace_points(path, state, i, i + 1, 2)
        write_point(points, i, cut.first)
        write_point(points, i + 1, cut.second)
        path.known[i] = 1
        state.at, state.halvings = i + 1, 0
    elif state.halvings + 1 < N_HALVINGS:
        state.halvings += 1
    else:
        state.at, state.halvings = i, 0
    return True


@routine
def replace_points(path, state, i, j, n_new):
    """Make room for n_new points in place of the points i to j - 1 of a path, i > 0; of the new edges none is known."""
    points, known, n, shift = path.waypoints, path.known, state.points, n_new - (j - i)
    for m in range(n - j):
        source = n - 1 - m if shift > 0 else j + m
        for k in range(points.shape[1]):
            points[source + shift, k] = points[source, k]
        known[source + shift] = known[source]
    for m in range(i - 1, i + n_new):
        known[m] = 0
    state.points = n + shift


@routine
def write_point(points, i, q):
    """Write a configuration to place i of a path."""
    for k in range(points.shape[1]):
        points[i, k] = q[k]


@routine
def length_of(points, n, space):
    """The length of the first n points of a path."""
    total = 0.0
    for i in range(n - 1):
        total += distance(points[i], points[i + 1], space)
    return total


@routine
def write_place(points, n, at, space, q):
    """Write the configuration at a length of a path to q; the edge on which it lies, and its length from the start."""
    done = 0.0
    for i in range(n - 1):
        step = distance(points[i], points[i + 1], space)
        if at <= done + step or i == n - 2:
            write_step(points[i], points[i + 1], min(1.0, (at - done) / step) if step > 0.0 else 0.0, space, q)
            return i, at
        done += step
    return 0, 0.0
