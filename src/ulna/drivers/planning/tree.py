"""Finds, reads and adds nodes of the trees of a search, takes its samples, and writes the path that joins the trees."""

import numpy as np

from ulna.drivers.planning.edge import passes
from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import WIDTH, lane_of
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import distance, nearest_below_in_lanes, nearest_in_lanes, short_way, write_step


@routine
def next_tree(state):
    """Which tree grows next: the other one, unless this one is less than half as large."""
    own = state[layout.ACTIVE]
    if state[1 - own] < 2 * state[own]:
        own = 1 - own
        state[layout.ACTIVE] = own
    return own


@routine
def read_sample(samples, space, state, q):
    """Write the configuration of the next sample to q; returns the row of the sample."""
    row = state[layout.SAMPLE] - state[layout.FIRST_SAMPLE]
    state[layout.SAMPLE] += 1
    for k in range(q.shape[0]):
        q[k] = space[layout.LOW, k] + samples[row, k] * (space[layout.HIGH, k] - space[layout.LOW, k])
    return row


@routine
def pass_over(state):
    """Count a sample that is skipped; so many of them are one checked edge of the budget."""
    state[layout.PASSED] += 1
    if state[layout.PASSED] % layout.PASSED_A_CHECK == 0:
        state[layout.CHECKS] += 1


@routine
def nearest_node(trees, tree, state, q, bound, space):
    """Of the nodes of a tree from which q costs at most a bound, the nearest to q (the first of several); -1 without any."""
    n_blocks = (state[tree] + WIDTH - 1) // WIDTH
    if trees.costs.shape[1] > 0:
        least, block = nearest_below_in_lanes(trees.rows[tree], trees.costs[tree], n_blocks, q, bound, space)
    else:
        least, block = nearest_in_lanes(trees.rows[tree], n_blocks, q, space)
    best, node = np.inf, -1
    for lane in range(WIDTH):
        square, i = lane_of(least, lane), WIDTH * int(lane_of(block, lane)) + lane
        if square < best or (square == best and i < node):
            best, node = square, i
    return node


@routine
def cost_of(trees, tree, node):
    """The cost of a node; 0 in a tree without costs."""
    return trees.costs[tree, node // WIDTH, node % WIDTH] if trees.costs.shape[1] > 0 else 0.0


@routine
def read_node(rows, node, q):
    """Write the configuration of a node to q."""
    n_dof = q.shape[0]
    for k in range(n_dof):
        q[k] = rows[node // WIDTH * n_dof + k, node % WIDTH]


@routine
def add_node(trees, tree, state, q, parent, radius, cost):
    """Add a node to a tree; its number. The cost is kept in a tree with costs."""
    rows, node, n_dof = trees.rows[tree], state[tree], q.shape[0]
    if node % WIDTH == 0:  # the first of its block: there are no others yet
        for k in range(n_dof):
            for lane in range(1, WIDTH):
                rows[node // WIDTH * n_dof + k, lane] = np.inf
    for k in range(n_dof):
        rows[node // WIDTH * n_dof + k, node % WIDTH] = q[k]
    trees.parents[tree, node], trees.radii[tree, node] = parent, radius
    if trees.costs.shape[1] > 0:
        trees.costs[tree, node // WIDTH, node % WIDTH] = cost
    state[tree] += 1
    return node


@kernel
def connect(context, trees, tree, steps, state, bound):
    """Step from the nearest node of a tree towards the configuration steps[2], again and again, until it is reached.

    Returns the node that reaches it for less than a bound of the cost, or -1: an edge is not free, or none is so cheap.
    """
    space, new, at, goal = context.space, steps[0], steps[1], steps[2]
    node = nearest_node(trees, tree, state, goal, bound, space)
    if node < 0:
        return -1
    read_node(trees.rows[tree], node, at)
    for _ in range(int(context.settings[layout.ROOM]) - 2):
        way, cost = distance(at, goal, space), cost_of(trees, tree, node)
        if way == 0.0:
            return node if cost < bound else -1
        if cost + way >= bound or state[layout.CHECKS] >= state[layout.MOST]:
            return -1
        share = min(1.0, context.settings[layout.RANGE] / way)
        write_step(at, goal, share, space, new)
        if not passes(context, at, new, trees.refused, state):
            return -1
        node = add_node(trees, tree, state, new, node, np.inf, cost + distance(at, new, space))
        if share == 1.0:
            return node
        for k in range(space.shape[1]):
            at[k] = new[k]
    return -1


@routine
def join(state, tree, node, other):
    """Note the node of a tree and the one of the other tree at which a path joins them."""
    state[layout.JOINED_START], state[layout.JOINED_GOAL] = (node, other) if tree == 0 else (other, node)
    state[layout.JOINED] = 1


@routine
def branch_length(parents, tree, node):
    """How many nodes there are from a node to its root."""
    n = 0
    while node >= 0:
        node, n = parents[tree, node], n + 1
    return n


@routine
def write_found(trees, space, shift, waypoints, state):
    """Write the path from the start to a goal; how many waypoints, or -1 if there is not room to shorten it too.

    The second part is turned by whole turns to where the first one ends. shift: room for these, shape (n_dof,).
    """
    node, other = state[layout.JOINED_START], state[layout.JOINED_GOAL]
    n, n_back = branch_length(trees.parents, 0, node), branch_length(trees.parents, 1, other)
    if rows_for(n + n_back) > waypoints.shape[0]:
        return -1
    for i in range(n):
        read_node(trees.rows[0], node, waypoints[n - 1 - i])
        node = trees.parents[0, node]
    read_node(trees.rows[1], other, waypoints[n])
    same = True
    for k in range(space.shape[1]):
        way = waypoints[n - 1, k] - waypoints[n, k]
        same = same and way == 0.0
        shift[k] = way - short_way(way, space[layout.PERIOD, k])
    at = n if n == 1 and not same else n - 1  # else the trees share a node, which is written already
    for i in range(n_back):
        if i > 0 or at == n:
            write_shifted(trees.rows[1], other, shift, waypoints, at + i)
        state[layout.REACHED], other = other, trees.parents[1, other]
    return at + n_back


@routine
def rows_for(n):
    """For how many waypoints there is to be room, to shorten a path of n."""
    return 2 * n + layout.SPARE_POINTS


@routine
def write_shifted(rows, node, shift, waypoints, i):
    """Write the configuration of a node, and what it is shifted by, to place i of a path."""
    read_node(rows, node, waypoints[i])
    for k in range(shift.shape[0]):
        if shift[k] != 0.0:
            waypoints[i, k] += shift[k]


@routine
def drop_repeats(waypoints, state):
    """Leave out the waypoints that are equal to the one before."""
    n = 1
    for i in range(1, state[layout.POINTS]):
        same = True
        for k in range(waypoints.shape[1]):
            same = same and waypoints[i, k] == waypoints[n - 1, k]
        if not same:
            for k in range(waypoints.shape[1]):
                waypoints[n, k] = waypoints[i, k]
            n += 1
    state[layout.POINTS] = n
