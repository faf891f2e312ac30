"""One iteration of RRT-Connect: two trees grow towards each other until an edge joins them.

Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning (ICRA 2000), with the domains of Jaillet et
al., Adaptive tuning of the sampling domain for dynamic-domain RRTs (IROS 2005):

1. If the straight edge from the start to a goal is free, that is the path; also, later, from the start to a new node of the
   second tree. With constraints, also steps along them from the start towards the first goal.
2. Take the next sample; unless one tree has twice as many nodes as the other, the trees change roles.
3. Find the nearest node of the first tree. If the sample lies outside its domain, take the next sample; but not more than
   MAX_SKIPPED times.
4. Step from the node towards the sample, by at most ``settings.range``, or less if edges of this tree have failed for long.
   If the edge is free, its end is a new node, else the node's domain shrinks. With constraints a step leads along them
   (``extension``).
5. Step from the nearest node of the second tree towards the new node, again and again, until it is reached, which joins the
   trees, or an edge is not free.
"""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.kernels.planning.space import adapted_domain, distance, write_step
from ulna.planning.entries.edge import passes
from ulna.planning.entries.extension import extend, gains_little, read_target
from ulna.planning.entries.tree import is_full, join, nearest_node, needs_samples, next_tree, pass_over, read_node
from ulna.planning.search_records import (
    BESIDE,
    FAILURES_PER_HALF,
    FULL,
    MAX_HALVES,
    MAX_SKIPPED,
    NO_SAMPLE,
    PAUSED,
    REACHED,
    SOLVED,
    STOPPED,
)


@kernel
def grow_trees(context, samples, trees, steps, state):
    """Search until the trees are joined, or ``state.until`` edges were checked, or nodes or samples run out.

    Returns SOLVED, PAUSED, FULL or NO_SAMPLE.
    """
    while state.checks < state.until:
        if state.direct < state.nodes[1]:
            if joins_directly(context, trees, steps, state):
                return SOLVED
        elif is_full(trees, context.settings, state):
            return FULL
        elif needs_samples(samples, state):
            return NO_SAMPLE
        elif iterate(context, samples, trees, steps, state):
            return SOLVED
    return PAUSED


@kernel
def joins_directly(context, trees, steps, state):
    """Step 1: whether the straight edge from the first start to the next node of the second tree is free."""
    goal, at, end = state.direct, steps.at, steps.new
    state.direct += 1
    read_node(trees.rows[0], 0, steps.target)
    read_node(trees.rows[1], goal, at)
    write_step(steps.target, at, 1.0, context.space, end)
    node = 0
    if not passes(context, steps.target, end, trees.refused, state):
        node = connect_along(context.keeping, context, trees, goal, steps, state)
    if node >= 0:
        join(state, 0, node, goal)
    return node >= 0


@kernel
def connect_along(keeping, context, trees, goal, steps, state):
    """With constraints, where the straight edge to the first goal is not free: the node by which they lead there, or -1."""
    if keeping is None:
        return -1
    return connect(context, trees, 0, steps.new, (steps.at, steps.target), state) if goal == 0 else -1


@kernel
def iterate(context, samples, trees, steps, state):
    """Steps 2 to 5; whether the trees are joined."""
    target, at, new, space, own = steps.target, steps.at, steps.new, context.space, next_tree(state)
    read_target(context.keeping, context, samples, state, target)  # 2
    near = nearest_node(trees.rows[own], state.nodes[own], target, space)  # 3
    read_node(trees.rows[own], near, at)
    way = distance(at, target, space)
    if is_skipped(way, trees.radii[own, near], state):
        return False
    write_step(at, target, min(1.0, longest_step(context.settings, own, state) / way), space, new)  # 4
    node = grow(context, trees, own, near, (at, new), state)
    if node < 0:
        return False
    other = connect(context, trees, 1 - own, new, (at, target), state)  # 5
    if other < 0:
        return False
    join(state, own, node, other)
    return True


@kernel
def is_skipped(way, radius, state):
    """Step 3: whether a sample so far away from the nearest node, which has a domain of a radius, is skipped."""
    if way == 0.0 or (way > radius and state.skipped_in_a_row < MAX_SKIPPED):
        state.skipped_in_a_row += 1
        pass_over(state)
        return True
    state.skipped_in_a_row = 0
    state.iterations += 1
    return False


@kernel
def longest_step(settings, own, state):
    """Step 4: how long a step of a tree towards a sample may be."""
    return settings.range / (1 << min(MAX_HALVES, state.failures[own] // FAILURES_PER_HALF))


@kernel
def grow(context, trees, own, near, step, state):
    """Step 4: extend a tree by a step from a node, and adapt the node's domain. The last node, or -1 if none was added."""
    settings, radii = context.settings, trees.radii
    before = radii[own, near]
    grown = adapted_domain(before, settings, extended=True)
    node, _ = extend(context, trees, own, near, step, grown, state)
    radii[own, near] = grown if node >= 0 else adapted_domain(before, settings, extended=False)
    state.failures[own] = 0 if node >= 0 else state.failures[own] + 1
    return node


@kernel
def connect(context, trees, tree, goal, step, state):
    """Step 5, towards a configuration: the node of the tree that reaches it, or -1. step: room for two configurations."""
    settings, space, rows, (at, new) = context.settings, context.space, trees.rows[tree], step
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
