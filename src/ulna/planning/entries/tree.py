"""Finds, reads and adds nodes of a search's trees, reads its samples, and writes the path between the trees."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import WIDTH, lane_of
from ulna.kernels.planning.space import nearest_in_lanes, short_way
from ulna.planning.entries.search_records import SKIPPED_PER_CHECK, SPARE_POINTS


class Steps(NamedTuple):
    """Workspaces for three configurations of an iteration, shape (n_dof,) each."""

    target: NDArray
    """The target of a step."""
    at: NDArray
    """The start of a step."""
    new: NDArray
    """The end of a step."""


@kernel
def is_full(trees, settings, state):
    """Whether a tree lacks room for the nodes of another iteration."""
    return max(state.nodes[0], state.nodes[1]) + settings.max_nodes > trees.parents.shape[1]


@kernel
def needs_samples(samples, state):
    """Whether all given samples are used."""
    return state.sample - state.first_sample >= samples.shape[0]


@routine
def next_tree(state):
    """The tree that grows next: the other one, unless it is at least twice as large."""
    own = state.active
    if state.nodes[1 - own] < 2 * state.nodes[own]:
        own = 1 - own
        state.active = own
    return own


@routine
def read_sample(samples, space, state, q):
    """Write the configuration of the next sample to q; return the row of the sample."""
    row = state.sample - state.first_sample
    state.sample += 1
    for k in range(q.shape[0]):
        q[k] = sample_entry(samples, space, row, k)
    return row


@kernel
def sample_entry(samples, space, row, k):
    """Entry k of the configuration of a sample."""
    return space[k].low + samples[row, k] * (space[k].high - space[k].low)


@routine
def skip_sample(state):
    """Count a skipped sample; SKIPPED_PER_CHECK of them count as one checked edge."""
    state.skipped += 1
    if state.skipped % SKIPPED_PER_CHECK == 0:
        state.checks += 1


@routine
def nearest_node(rows, n, q, space):
    """The node nearest to q in a tree of n nodes; the first of several."""
    least, block = nearest_in_lanes(rows, (n + WIDTH - 1) // WIDTH, q, space)
    best, node = np.inf, 0
    for lane in range(WIDTH):
        square, i = lane_of(least, lane), WIDTH * int(lane_of(block, lane)) + lane
        if square < best or (square == best and i < node):
            best, node = square, i
    return node


@routine
def read_node(rows, node, q):
    """Write the configuration of a node to q."""
    n_dof = q.shape[0]
    for k in range(n_dof):
        q[k] = rows[node // WIDTH * n_dof + k, node % WIDTH]


@routine
def add_node(trees, tree, state, q, parent, radius):
    """Add a node to a tree, and return its number."""
    rows, node, n_dof = trees.rows[tree], state.nodes[tree], q.shape[0]
    if node % WIDTH == 0:  # the first node of its block: the other lanes are empty
        for k in range(n_dof):
            for lane in range(1, WIDTH):
                rows[node // WIDTH * n_dof + k, lane] = np.inf
    for k in range(n_dof):
        rows[node // WIDTH * n_dof + k, node % WIDTH] = q[k]
    trees.parents[tree, node], trees.radii[tree, node] = parent, radius
    state.nodes[tree] += 1
    return node


@routine
def join(state, tree, node, other):
    """Record the nodes of both trees at which a path joins them."""
    state.joined_start, state.joined_goal = (node, other) if tree == 0 else (other, node)
    state.joined = True


@routine
def branch_length(parents, tree, node):
    """The number of nodes from a node to its root."""
    n = 0
    while node >= 0:
        node, n = parents[tree, node], n + 1
    return n


@routine
def write_found(trees, space, shift, waypoints, state):
    """Write the path from the start to a goal, and return the number of waypoints.

    The number is -1 if there is no room to shorten the path. The second part is shifted by whole turns to join the first part.
    shift: room for these turns, shape (n_dof,).
    """
    node, other = state.joined_start, state.joined_goal
    n, n_back = branch_length(trees.parents, 0, node), branch_length(trees.parents, 1, other)
    if rows_for(n + n_back) > waypoints.shape[0]:
        return -1
    for i in range(n):
        read_node(trees.rows[0], node, waypoints[n - 1 - i])
        node = trees.parents[0, node]
    read_node(trees.rows[1], other, waypoints[n])
    same = True
    for k in range(space.shape[0]):
        way = waypoints[n - 1, k] - waypoints[n, k]
        same = same and way == 0.0
        shift[k] = way - short_way(way, space[k].period)
    at = n if n == 1 and not same else n - 1  # otherwise the trees share a node, which is already written
    for i in range(n_back):
        if i > 0 or at == n:
            write_shifted(trees.rows[1], other, shift, waypoints, at + i)
        state.goal, other = other, trees.parents[1, other]
    return at + n_back


@routine
def rows_for(n):
    """The required capacity to shorten a path of n waypoints."""
    return 2 * n + SPARE_POINTS


@routine
def write_shifted(rows, node, shift, waypoints, i):
    """Write the configuration of a node, plus a shift, to point i of a path."""
    read_node(rows, node, waypoints[i])
    for k in range(shift.shape[0]):
        if shift[k] != 0.0:
            waypoints[i, k] += shift[k]


@routine
def drop_repeats(waypoints, state):
    """Remove waypoints equal to the previous one."""
    n = 1
    for i in range(1, state.points):
        same = True
        for k in range(waypoints.shape[1]):
            same = same and waypoints[i, k] == waypoints[n - 1, k]
        if not same:
            for k in range(waypoints.shape[1]):
                waypoints[n, k] = waypoints[i, k]
            n += 1
    state.points = n
