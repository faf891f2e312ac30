"""Shortens a path of free edges."""

from typing import NamedTuple

from numpy.typing import NDArray

from ulna.engine.decorators import kernel, routine
from ulna.kernels.planning.space import distance, write_step
from ulna.planning.entries.edge import is_free
from ulna.planning.entries.extension import gains_little, write_curve
from ulna.planning.entries.search_records import BESIDE, CONFIRM, NOT_FREE, PAUSED, REACHED, SOLVED, STOPPED

N_ATTEMPTS = 48  # attempts of pass 2
N_FAILURES = 8  # failures in a row that end pass 2, with constraints
LEAVE_OUT = 4  # the number of the pass that removes points
N_HALVINGS = 3  # cuts of a corner are tried at 1/2, 1/4 and 1/8 of its edges
WORTH_A_CUT = 1e-3  # minimum gain of a cut, as a share of the path's length
_FIRST_SHARE, _SECOND_SHARE = 0.7548776662466927, 0.5698402909980532  # 1/p, 1/p^2 of the plastic number: Roberts's R2 (2018)


class Cut(NamedTuple):
    """Workspaces for a shortcut, shape (n_dof,) each."""

    first: NDArray
    """The start of the shortcut."""
    second: NDArray
    """The end of the shortcut."""
    at: NDArray
    """The start of a step along constraints."""
    new: NDArray
    """The end of a step along constraints."""


@routine
def shorten_path(context, path, cut, state):
    """Shorten a path in place, in passes, until all passes end or ``state.until`` edges are checked.

    The first ``state.points`` waypoints are in use. Returns SOLVED, PAUSED or NOT_FREE. The passes:

    1. From each point in turn, connect straight to the farthest point that a free edge reaches; skipped with constraints.
       (Geraerts and Overmars, Creating high-quality paths for motion planning, IJRR 2007.)
    2. Connect two points of the path at shares of its length from a low-discrepancy sequence, by a straight edge or along the
       constraints.
    3. Cut each corner by a free edge between the middles of its two edges, or nearer to the corner. The rest of the two edges is
       part of free edges. Repeat once.
    4. Remove each point whose neighbors a free edge connects.
    5. Confirm every edge that is not known to be free. Returns NOT_FREE if an edge is not free.
    """
    while state.checks < state.until:
        if state.stage == CONFIRM:
            if state.at >= state.points - 1:
                return SOLVED
            if not confirm_edge(context, path, state):
                return NOT_FREE
        elif not advance_pass(context, path, cut, state):
            state.at = state.target = state.failures = state.halvings = 0
            state.stage += 1
    return PAUSED


@kernel
def advance_pass(context, path, cut, state):
    """Try one edge of the current pass; False if the pass is finished."""
    if state.stage == 0:
        return context.keeping is None and connect_farther(context, path, state)
    if state.stage == 1:
        return try_shortcut(context, path, cut, state)
    if state.stage < LEAVE_OUT:
        return cut_corner(context, path, cut, state)
    return remove_point(context, path, state)


@kernel
def check_free(context, q_a, q_b, state):
    """Check and count an edge: whether it is free."""
    state.checks += 1
    return is_free(context, q_a, q_b, context.no_spread)


@kernel
def confirm_edge(context, path, state):
    """Whether the next edge of the path, within its spread, is free, checked in one direction or the other."""
    i, points, spreads = state.at, path.waypoints, path.spreads
    state.at += 1
    if path.known[i] == 1:
        return True
    state.checks += 1
    spread = spreads[i] if spreads.shape[0] > 0 else context.no_spread
    return is_free(context, points[i], points[i + 1], spread) or is_free(context, points[i + 1], points[i], spread)


@kernel
def connect_farther(context, path, state):
    """Try one edge of pass 1; False if the pass is finished."""
    n, i = state.points, state.at
    if i >= n - 2:
        return False
    j = n - 1 if state.target == 0 else state.target
    if check_free(context, path.waypoints[i], path.waypoints[j], state):
        replace_points(path, state, i + 1, j, 0)
        path.known[i], j = 1, i + 1
    state.target = j - 1
    if j - 1 <= i + 1:
        state.at, state.target = i + 1, 0
    return True


@kernel
def remove_point(context, path, state):
    """Try one edge of pass 4; False if the pass is finished."""
    i = state.at
    if i >= state.points - 2:
        return False
    if check_free(context, path.waypoints[i], path.waypoints[i + 2], state):
        replace_points(path, state, i + 1, i + 2, 0)
        path.known[i] = 1
    else:
        state.at += 1
    return True


@kernel
def try_shortcut(context, path, cut, state):
    """Make one attempt of pass 2; False if the pass is finished."""
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
    return make_shortcut(context.keeping, context, path, (i, j), cut, most, state)


@kernel
def make_shortcut(keeping, context, path, edges, cut, most, state):
    """Try a shortcut between two points on edges, straight or along constraints; False if the pass is finished."""
    i, j = edges
    points = path.waypoints
    if keeping is not None:
        return make_shortcut_along(context, path, i, j, cut, most, state)
    if check_free(context, cut.first, cut.second, state):
        replace_points(path, state, i + 1, j + 1, 2)
        write_point(points, i + 1, cut.first)
        write_point(points, i + 2, cut.second)
        path.known[i + 1] = 1
    return True


@routine
def make_shortcut_along(context, path, i, j, cut, most, state):
    """Make a shortcut along the constraints between points on edges i and j, at most ``most`` long.

    The pass ends after N_FAILURES in a row, since such a shortcut needs as many edges as a part of the path.
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
    """Write the waypoints along the constraints from cut.first (excluded) to cut.second: their number.

    They are written to the path's last rows, from the last row backwards. The number is 0 if there is no such path, or it is
    longer than ``most``, or there is no room.
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
    """Try one edge of pass 3; False if the pass is finished."""
    points, n, i, space = path.waypoints, state.points, state.at + 1, context.space
    if i >= n - 1 or n + 1 > state.capacity:
        return False
    share = 0.5 / (1 << state.halvings)  # a shift, since a power would call exp2, which the wheel lacks
    write_step(points[i], points[i - 1], share, space, cut.first)
    write_step(points[i], points[i + 1], share, space, cut.second)
    around = share * (distance(points[i - 1], points[i], space) + distance(points[i], points[i + 1], space))
    if around - distance(cut.first, cut.second, space) < WORTH_A_CUT * length_of(points, n, space):
        state.at, state.halvings = i, 0
        return True
    if check_free(context, cut.first, cut.second, state):
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
    """Replace points i to j - 1 of a path, i > 0, by room for n_new unknown points."""
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
    """Write a configuration to point i of a path."""
    for k in range(points.shape[1]):
        points[i, k] = q[k]


@routine
def length_of(points, n, space):
    """The length of a path of n points."""
    total = 0.0
    for i in range(n - 1):
        total += distance(points[i], points[i + 1], space)
    return total


@routine
def write_place(points, n, at, space, q):
    """Write the configuration at a length along a path to q: its edge, and its length from the start."""
    done = 0.0
    for i in range(n - 1):
        step = distance(points[i], points[i + 1], space)
        if at <= done + step or i == n - 2:
            write_step(points[i], points[i + 1], min(1.0, (at - done) / step) if step > 0.0 else 0.0, space, q)
            return i, at
        done += step
    return 0, 0.0
