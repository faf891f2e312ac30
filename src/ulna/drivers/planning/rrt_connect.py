"""One iteration of RRT-Connect: two trees grow towards each other until an edge joins them.

Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning (ICRA 2000), with the domains of Jaillet et
al., Adaptive tuning of the sampling domain for dynamic-domain RRTs (IROS 2005):

1. If the straight edge from the start to a goal is free, that is the path; also, later, from the start to a new node of the
   second tree. With constraints, also steps along them from the start towards the first goal.
2. Take the next sample; unless one tree has twice as many nodes as the other, the trees change roles.
3. Find the nearest node of the first tree. If the sample lies outside its domain, take the next sample; but not more than
   MOST_IN_A_ROW times.
4. Step from the node towards the sample, by at most RANGE, or less if edges of this tree have failed for long. If the edge is
   free, its end is a new node, else the node's domain shrinks. With constraints a step leads along them (``extension``).
5. Step from the nearest node of the second tree towards the new node, again and again, until it is reached, which joins the
   trees, or an edge is not free.
"""

import numpy as np

from ulna.drivers.planning.edge import passes
from ulna.drivers.planning.extension import extend, gains_little, read_target
from ulna.drivers.planning.tree import join, nearest_node, next_tree, pass_over, read_node
from ulna.engine.decorators import kernel
from ulna.kernels.planning.search_records import BESIDE, FAILURES_PER_HALF, MAX_HALVES, MAX_SKIPPED, REACHED, STOPPED
from ulna.kernels.planning.space import adapted_domain, distance, write_step


@kernel
def joins_directly(context, trees, steps, state):
    """Step 1: whether the straight edge from the first start to the next node of the second tree is free."""
    goal = state.direct
    state.direct += 1
    read_node(trees.rows[0], 0, steps[0])
    read_node(trees.rows[1], goal, steps[1])
    write_step(steps[0], steps[1], 1.0, context.space, steps[2])
    node = 0
    if not passes(context, steps[0], steps[2], trees.refused, state):
        node = connect_along(context.keeping, context, trees, goal, steps, state)
    if node >= 0:
        join(state, 0, node, goal)
    return node >= 0


@kernel
def connect_along(keeping, context, trees, goal, steps, state):
    """With constraints, where the straight edge to the first goal is not free: the node by which they lead there, or -1."""
    if keeping is None:
        return -1
    return connect(context, trees, 0, steps, state) if goal == 0 else -1


@kernel
def iterate(context, samples, trees, steps, state):
    """Steps 2 to 5; whether the trees are joined."""
    settings, space, own = context.settings, context.space, next_tree(state)
    rows, radii = trees.rows[own], trees.radii
    target, at, new = steps[0], steps[1], steps[2]
    read_target(context.keeping, context, samples, state, target)
    near = nearest_node(rows, state.nodes[own], target, space)
    read_node(rows, near, at)
    way = distance(at, target, space)
    if way == 0.0 or (way > radii[own, near] and state.skipped_in_a_row < MAX_SKIPPED):
        state.skipped_in_a_row += 1
        pass_over(state)
        return False
    state.skipped_in_a_row = 0
    state.iterations += 1
    halves = min(MAX_HALVES, state.failures[own] // FAILURES_PER_HALF)
    write_step(at, target, min(1.0, settings.range / (1 << halves) / way), space, new)
    before, domain, least = radii[own, near], settings.domain, settings.min_domain
    rate = settings.adaptation
    grown = adapted_domain(before, extended=True, domain=domain, least=least, rate=rate)
    node, _ = extend(context, trees, own, near, (at, new), grown, state)
    extended = node >= 0
    radii[own, near] = grown if extended else adapted_domain(before, extended=False, domain=domain, least=least, rate=rate)
    state.failures[own] = 0 if extended else state.failures[own] + 1
    if not extended:
        return False
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
    node = nearest_node(rows, state.nodes[tree], goal, space)
    read_node(rows, node, at)
    for _ in range(settings.max_steps):
        way = distance(at, goal, space)
        if way == 0.0:
            return node
        if state.checks >= state.max_checks:
            return -1
        share = min(1.0, settings.range / way)
        write_step(at, goal, share, space, new)
        node, end = extend(context, trees, tree, node, (at, new), np.inf, state)
        if end == STOPPED:
            return -1
        if share == 1.0 and end == REACHED:
            return node
        if end == BESIDE and gains_little(new, goal, way, share, space):
            return -1
        for k in range(space.shape[0]):
            at[k] = new[k]
    return -1
