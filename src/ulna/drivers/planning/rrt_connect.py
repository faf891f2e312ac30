"""One iteration of RRT-Connect: two trees grow towards each other until an edge joins them.

Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning (ICRA 2000), with the domains of Jaillet et
al., Adaptive tuning of the sampling domain for dynamic-domain RRTs (IROS 2005):

1. If the straight edge from the start to a goal is free, that is the path; also, later, from the start to a new node of the
   second tree.
2. Take the next sample; unless one tree has twice as many nodes as the other, the trees change roles.
3. Find the nearest node of the first tree. If the sample lies outside its domain, take the next sample; but not more than
   MOST_IN_A_ROW times.
4. Step from the node towards the sample, by at most RANGE, or less if edges of this tree have failed for long. If the edge is
   free, its end is a new node, else the node's domain shrinks.
5. Step from the nearest node of the second tree towards the new node, again and again, until it is reached, which joins the
   trees, or an edge is not free.
"""

import numpy as np

from ulna.drivers.planning.edge import passes
from ulna.drivers.planning.tree import add_node, join, nearest_node, next_tree, pass_over, read_node, read_sample
from ulna.engine.decorators import kernel
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import adapted_domain, distance, write_step


@kernel
def joins_directly(context, trees, steps, state):
    """Step 1: whether the straight edge from the first start to the next node of the second tree is free."""
    goal = state[layout.DIRECT]
    state[layout.DIRECT] += 1
    read_node(trees.rows[0], 0, steps[0])
    read_node(trees.rows[1], goal, steps[1])
    write_step(steps[0], steps[1], 1.0, context.space, steps[2])
    if not passes(context, steps[0], steps[2], trees.refused, state):
        return False
    join(state, 0, 0, goal)
    return True


@kernel
def iterate(context, samples, trees, steps, state):
    """Steps 2 to 5; whether the trees are joined."""
    settings, space, own = context.settings, context.space, next_tree(state)
    rows, radii = trees.rows[own], trees.radii
    target, at, new = steps[0], steps[1], steps[2]
    read_sample(samples, space, state, target)
    near = nearest_node(rows, state[own], target, space)
    read_node(rows, near, at)
    way = distance(at, target, space)
    if way == 0.0 or (way > radii[own, near] and state[layout.IN_A_ROW] < layout.MOST_IN_A_ROW):
        state[layout.IN_A_ROW] += 1
        pass_over(state)
        return False
    state[layout.IN_A_ROW] = 0
    state[layout.ITERATIONS] += 1
    halves = min(layout.MOST_HALVES, state[layout.FAILED + own] // layout.FAILED_A_HALF)
    write_step(at, target, min(1.0, settings[layout.RANGE] / (1 << halves) / way), space, new)
    extended = passes(context, at, new, trees.refused, state)
    radii[own, near] = adapted_domain(
        radii[own, near], extended, settings[layout.DOMAIN], settings[layout.LEAST_DOMAIN], settings[layout.ADAPTATION]
    )
    state[layout.FAILED + own] = 0 if extended else state[layout.FAILED + own] + 1
    if not extended:
        return False
    node = add_node(trees, own, state, new, near, radii[own, near])
    other = connect(context, trees, 1 - own, steps, state)
    if other < 0:
        return False
    join(state, own, node, other)
    return True


@kernel
def connect(context, trees, tree, steps, state):
    """Step 5, towards the configuration steps[2]: the node of the tree that reaches it, or -1."""
    settings, space, rows = context.settings, context.space, trees.rows[tree]
    new, at, goal = steps[0], steps[1], steps[2]
    node = nearest_node(rows, state[tree], goal, space)
    read_node(rows, node, at)
    for _ in range(int(settings[layout.ROOM]) - 2):
        way = distance(at, goal, space)
        if way == 0.0:
            return node
        if state[layout.CHECKS] >= state[layout.MOST]:
            return -1
        share = min(1.0, settings[layout.RANGE] / way)
        write_step(at, goal, share, space, new)
        if not passes(context, at, new, trees.refused, state):
            return -1
        node = add_node(trees, tree, state, new, node, np.inf)
        if share == 1.0:
            return node
        for k in range(space.shape[1]):
            at[k] = new[k]
    return -1
