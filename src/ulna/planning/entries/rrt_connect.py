"""Implements RRT-Connect: two trees grow towards each other until an edge joins them.

Sources: Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning (ICRA 2000). Jaillet et al.,
Adaptive tuning of the sampling domain for dynamic-domain RRTs (IROS 2005), for the domains of nodes.

1. Try the straight edge from the start to each goal, and later to each new node of the second tree. If it is free, the path is
   found. With constraints, also try steps along them from the start towards the first goal.
2. Take the next sample. The trees change roles, unless one tree has at least twice as many nodes as the other.
3. Find the nearest node of the first tree. If the sample lies outside its domain, take the next sample, at most MAX_SKIPPED
   times.
4. Extend the node by a step towards the sample, of length ``settings.range`` at most, or less after many failed edges of this
   tree. If the edge is free, its end becomes a new node; else the node's domain shrinks. With constraints, a step follows them
   (``extension``).
5. Extend the nearest node of the second tree towards the new node, until it is reached or an edge is not free. If it is reached,
   the trees are joined.
"""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.kernels.planning.space import adapted_domain, distance, write_step
from ulna.planning.entries.edge import check_edge
from ulna.planning.entries.extension import extend, gains_little, read_target
from ulna.planning.entries.search_records import (
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
from ulna.planning.entries.tree import is_full, join, nearest_node, needs_samples, next_tree, read_node, skip_sample


@kernel
def grow_trees(context, samples, trees, steps, state):
    """Search until the trees are joined, ``state.until`` edges are checked, or nodes or samples run out.

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
    """Perform step 1: whether the start is joined to the next node of the second tree."""
    goal, at, end = state.direct, steps.at, steps.new
    state.direct += 1
    read_node(trees.rows[0], 0, steps.target)
    read_node(trees.rows[1], goal, at)
    write_step(steps.target, at, 1.0, context.space, end)
    node = 0
    if not check_edge(context, steps.target, end, trees.refused, state):
        node = connect_along(context.keeping, context, trees, goal, steps, state)
    if node >= 0:
        join(state, 0, node, goal)
    return node >= 0


@kernel
def connect_along(keeping, context, trees, goal, steps, state):
    """Step along the constraints, if any, from the start to the first goal: the node that reaches it, or -1."""
    if keeping is None:
        return -1
    return connect(context, trees, 0, steps.new, (steps.at, steps.target), state) if goal == 0 else -1


@kernel
def iterate(context, samples, trees, steps, state):
    """Perform steps 2 to 5; True if the trees are joined."""
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
    """Perform step 3: whether to skip a sample at a distance from the nearest node, whose domain has a radius."""
    if way == 0.0 or (way > radius and state.skipped_in_a_row < MAX_SKIPPED):
        state.skipped_in_a_row += 1
        skip_sample(state)
        return True
    state.skipped_in_a_row = 0
    state.iterations += 1
    return False


@kernel
def longest_step(settings, own, state):
    """The maximum length of a tree's step towards a sample, in step 4."""
    return settings.range / (1 << min(MAX_HALVES, state.failures[own] // FAILURES_PER_HALF))


@kernel
def grow(context, trees, own, near, step, state):
    """Perform step 4: extend a node by a step, and adapt its domain. The last new node, or -1."""
    settings, radii = context.settings, trees.radii
    before = radii[own, near]
    grown = adapted_domain(before, settings, extended=True)
    node, _ = extend(context, trees, own, near, step, grown, state)
    radii[own, near] = grown if node >= 0 else adapted_domain(before, settings, extended=False)
    state.failures[own] = 0 if node >= 0 else state.failures[own] + 1
    return node


@kernel
def connect(context, trees, tree, goal, step, state):
    """Perform step 5, towards a configuration: the node that reaches it, or -1. step: room for two configurations."""
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
