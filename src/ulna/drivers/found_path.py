"""Writes the path that a search has found, and leaves out its repeats."""

from ulna.drivers.tree_nodes import read_node
from ulna.engine.decorators import routine
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import short_way


@routine
def branch_length(parents, tree, node):
    """How many nodes there are from a node to its root."""
    n = 0
    while node >= 0:
        node, n = parents[tree, node], n + 1
    return n


@routine
def write_found(start_rows, goal_rows, parents, space, shift, path, state):
    """Write the path from the start to a goal; how many points, or -1 if there is not room to shorten it too.

    The second part is turned by whole turns to where the first one ends. shift: room for these, shape (n_dof,).
    """
    node, other = state[layout.JOINED_START], state[layout.JOINED_GOAL]
    n, n_back = branch_length(parents, 0, node), branch_length(parents, 1, other)
    if rows_for(n + n_back) > path.shape[0]:
        return -1
    for i in range(n):
        read_node(start_rows, node, path[n - 1 - i])
        node = parents[0, node]
    read_node(goal_rows, other, path[n])
    same = True
    for k in range(space.shape[1]):
        way = path[n - 1, k] - path[n, k]
        same = same and way == 0.0
        shift[k] = way - short_way(way, space[layout.PERIOD, k])
    at = n if n == 1 and not same else n - 1  # else the trees share a node, which is written already
    for i in range(n_back):
        if i > 0 or at == n:
            write_shifted(goal_rows, other, shift, path, at + i)
        state[layout.REACHED], other = other, parents[1, other]
    return at + n_back


@routine
def rows_for(n):
    """For how many points there is to be room, to shorten a path of n."""
    return 2 * n + layout.SPARE_POINTS


@routine
def write_shifted(rows, node, shift, path, i):
    """Write the configuration of a node, and what it is shifted by, to place i of a path."""
    read_node(rows, node, path[i])
    for k in range(shift.shape[0]):
        if shift[k] != 0.0:
            path[i, k] += shift[k]


@routine
def drop_repeats(path, state):
    """Leave out the points of a path that are the same as the one before."""
    n = 1
    for i in range(1, state[layout.POINTS]):
        same = True
        for k in range(path.shape[1]):
            same = same and path[i, k] == path[n - 1, k]
        if not same:
            for k in range(path.shape[1]):
                path[n, k] = path[i, k]
            n += 1
    state[layout.POINTS] = n
