"""Implements an iteration of AORRTC, which searches for a path with a cost below a bound.

Wilson, Thomason, Kingston and Gammell, AORRTC: almost-surely asymptotically optimal planning with RRT-Connect (RA-L 2025), after
Hauser and Zhou, Asymptotically optimal planning by feasible kinodynamic planning in a state-cost space (T-RO 2016). The cost of
a node is the length of its path from the root of its tree. Let g and h be the distances of a configuration from the nearest root
of its own tree and of the other tree. They are lower bounds of the cost to come and the cost to go.

1. A sample is skipped unless g + h is below the bound. Otherwise its cost bound is drawn between g and the bound minus h.
2. Among the nodes from which the sample's cost is within its cost bound, the nearest is extended by a step towards the sample.
   The end becomes a new node if its cost plus its h is below the bound and the edge is free.
3. A new parent is drawn, with a lower cost bound, as long as this lowers the cost of the node.
4. The other tree is extended towards the node, from the nearest node that keeps the total cost below the bound.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import WIDTH, lane_of
from ulna.kernels.planning.space import distance, nearest_below_in_lanes, write_step
from ulna.planning.entries.edge import check_edge
from ulna.planning.entries.search_records import FULL, NO_SAMPLE, PAUSED, SOLVED
from ulna.planning.entries.tree import add_node, is_full, join, needs_samples, next_tree, read_node, read_sample, skip_sample

_GOLDEN = 0.6180339887498949  # golden-ratio sequence: draw k of a parent uses frac(share + k phi)
_MAX_PARENTS = 8
INF = float("inf")


@kernel
def grow_cheaper(context, samples, trees, steps, state):
    """Search by iterations of AORRTC; same results as ``rrt_connect.grow_trees``."""
    while state.checks < state.until:
        if is_full(trees, context.settings, state):
            return FULL
        if needs_samples(samples, state):
            return NO_SAMPLE
        if iterate_cheaper(context, samples, trees, steps, state):
            return SOLVED
    return PAUSED


@routine
def iterate_cheaper(context, samples, trees, steps, state):
    """Perform steps 1 to 4; True if a path with a cost below the bound joins the trees."""
    own, bound = next_tree(state), context.settings.bound
    row = read_sample(samples, context.space, state, steps.target)
    share = samples[row, context.space.shape[0]]
    parent, cost = cheaper_step(context, trees, own, steps, state, share)
    if parent < 0:
        return False
    parent, cost = cheaper_parent(context, trees, own, steps, state, (parent, cost), share)
    node = add_node(trees, own, state, steps.new, parent, INF)
    set_cost(trees.costs[own], node, cost)
    other = connect_below(context, trees, 1 - own, steps, state, bound - cost)
    if other < 0:
        return False
    join(state, own, node, other)
    return True


@routine
def cheaper_step(context, trees, tree, steps, state, share):
    """Perform steps 1 and 2, from the sample ``target`` to ``new``.

    Returns:
        The extended node, or -1; and the cost of ``new``.
    """
    space, bound, rows, costs = context.space, context.settings.bound, trees.rows[tree], trees.costs[tree]
    target, at, new = steps.target, steps.at, steps.new
    least = from_roots(trees, tree, target, at, space, state)
    most = bound - from_roots(trees, 1 - tree, target, at, space, state)
    node = nearest_below(rows, costs, state.nodes[tree], target, least + share * (most - least), space) if least < most else -1
    cost = INF
    if node >= 0:
        read_node(rows, node, at)
        way = distance(at, target, space)
        if way > 0.0:
            write_step(at, target, min(1.0, context.settings.range / way), space, new)
            cost = cost_of(costs, node) + distance(at, new, space)
    if cost == INF or cost + from_roots(trees, 1 - tree, new, at, space, state) >= bound:
        skip_sample(state)
        return -1, INF
    read_node(rows, node, at)
    state.iterations += 1
    return (node, cost) if check_edge(context, at, new, trees.refused, state) else (-1, INF)


@routine
def cheaper_parent(context, trees, tree, steps, state, found, share):
    """Perform step 3: the best drawn parent of the configuration ``new``, and the cost of ``new``.

    found: the first parent, and the cost of ``new`` with it.
    """
    parent, cost = found
    space, rows, costs, at, new = context.space, trees.rows[tree], trees.costs[tree], steps.at, steps.new
    least = from_roots(trees, tree, new, at, space, state)
    for _ in range(_MAX_PARENTS):
        share = (share + _GOLDEN) % 1.0
        candidate = nearest_below(rows, costs, state.nodes[tree], new, least + share * (cost - least), space)
        if candidate < 0:
            break
        read_node(rows, candidate, at)
        way = distance(at, new, space)
        if candidate == parent or way > context.settings.range or cost_of(costs, candidate) + way >= cost:
            break
        if not check_edge(context, at, new, trees.refused, state):
            break
        parent, cost = candidate, cost_of(costs, candidate) + way
    return parent, cost


@routine
def connect_below(context, trees, tree, steps, state, bound):
    """Perform step 4, towards the configuration ``new``: the node that reaches it with a cost below a bound, or -1."""
    space, new, at, goal = context.space, steps.target, steps.at, steps.new
    rows, costs = trees.rows[tree], trees.costs[tree]
    node = nearest_below(rows, costs, state.nodes[tree], goal, bound, space)
    if node < 0:
        return -1
    read_node(rows, node, at)
    for _ in range(context.settings.max_steps):
        way, cost = distance(at, goal, space), cost_of(costs, node)
        if way == 0.0:
            return node if cost < bound else -1
        if cost + way >= bound or state.checks >= state.max_checks:
            return -1
        share = min(1.0, context.settings.range / way)
        write_step(at, goal, share, space, new)
        if not check_edge(context, at, new, trees.refused, state):
            return -1
        node = add_node(trees, tree, state, new, node, INF)
        set_cost(costs, node, cost + distance(at, new, space))
        if share == 1.0:
            return node
        for k in range(space.shape[0]):
            at[k] = new[k]
    return -1


@routine
def from_roots(trees, tree, q, at, space, state):
    """The distance of q from the nearest root of a tree."""
    least = INF
    for root in range(1 if tree == 0 else state.goal_roots):
        read_node(trees.rows[tree], root, at)
        least = min(least, distance(at, q, space))
    return least


@routine
def nearest_below(rows, costs, n, q, bound, space):
    """The nearest of n nodes from which the cost of q is at most a bound; -1 without any."""
    least, block = nearest_below_in_lanes(rows, costs, (n + WIDTH - 1) // WIDTH, q, bound, space)
    best, node = INF, -1
    for lane in range(WIDTH):
        square, i = lane_of(least, lane), WIDTH * int(lane_of(block, lane)) + lane
        if square < best or (square == best and square < INF and i < node):
            best, node = square, i
    return node


@routine
def cost_of(costs, node):
    """The cost to reach a node."""
    return costs[node // WIDTH, node % WIDTH]


@routine
def set_cost(costs, node, cost):
    """Set the cost to reach a node."""
    costs[node // WIDTH, node % WIDTH] = cost
