"""Finds, reads and adds nodes of the trees of a search; see ``kernels.planning.space``."""

import numpy as np

from ulna.engine.decorators import routine
from ulna.engine.lanes import WIDTH, lane_of
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import nearest_in_lanes


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
    """Count a sample of which nothing comes; so many of them are one checked edge of the budget."""
    state[layout.PASSED] += 1
    if state[layout.PASSED] % layout.PASSED_A_CHECK == 0:
        state[layout.CHECKS] += 1


@routine
def nearest_node(rows, n, q, space):
    """The node of a tree of n nodes that is nearest to q; of several the first."""
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
def add_node(rows, parents, radii, tree, state, q, parent, radius):
    """Add a node to a tree; its number."""
    node, n_dof = state[tree], q.shape[0]
    if node % WIDTH == 0:  # the first of its block: there are no others yet
        for k in range(n_dof):
            for lane in range(1, WIDTH):
                rows[node // WIDTH * n_dof + k, lane] = np.inf
    for k in range(n_dof):
        rows[node // WIDTH * n_dof + k, node % WIDTH] = q[k]
    parents[tree, node], radii[tree, node] = parent, radius
    state[tree] += 1
    return node
