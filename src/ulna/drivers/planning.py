"""Grows two trees towards each other until an edge joins them, and shortens the path.

RRT-Connect (Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA 2000), with the domains
of Jaillet et al. (Adaptive tuning of the sampling domain for dynamic-domain RRTs, IROS 2005):

1. If the straight edge from the start to a goal is free, that is the path; also, later, from the start to a new node of the
   second tree.
2. Take the next sample; unless one tree has twice as many nodes as the other, the trees change roles.
3. Find the nearest node of the first tree. If the sample lies outside its domain, take the next sample; but not more than
   MOST_IN_A_ROW times.
4. Step from the node towards the sample, by at most RANGE, or less if edges of this tree have failed for long. If the edge is
   free, its end is a new node, else the node's domain shrinks.
5. Step from the nearest node of the second tree towards the new node, again and again, until it is reached, which joins the
   trees, or an edge is not free.

With costs of the nodes it is the search of AORRTC for a path that costs less than a bound; see ``cheaper``.

All that a search knows is in arrays that the caller owns. So it may be ended after any iteration and go on in another call, and
its bits do not depend on where. There is no clock in it: the samples are given, and the budget is a number of edges.
"""

import numpy as np

from ulna.drivers.cheaper import iterate_cheaper
from ulna.drivers.found_path import drop_repeats, rows_for, write_found
from ulna.drivers.planned_edge import edges_of, is_free, straight_edges_of
from ulna.drivers.shortening import shorten_path
from ulna.drivers.tree_nodes import add_node, nearest_node, next_tree, pass_over, read_node, read_sample
from ulna.engine.decorators import entry, kernel
from ulna.engine.signatures import INDEX_ROWS, MATRIX, NUMBERS, SCENES
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import adapted_domain, distance, write_step

_TREES = MATRIX, MATRIX, MATRIX, INDEX_ROWS, MATRIX, MATRIX
_MORE = (NUMBERS, MATRIX, *_TREES, MATRIX, MATRIX, INDEX_ROWS, INDEX_ROWS)


@entry(*((*scene, *_MORE) for scene in SCENES))
def plan_slice(
    joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch,
    settings, space, samples, start_rows, goal_rows, parents, radii, costs, spreads, path, known, state,
):  # fmt: skip
    """Go on with a search, and then with the shortening of the path, until state[0, UNTIL] or state[1, UNTIL] edges were checked.

    It is one entry, since each compiles what decides whether an edge is free, which takes longest, and since a call takes as long
    as an edge.

    samples: (n, n_dof or more) of numbers in [0, 1), the first that of index state[0, FIRST_SAMPLE]; start_rows, goal_rows: the
    trees (``kernels.planning.space``); parents, radii: (2, capacity), -1 for a root; costs: of the nodes of the first tree and
    then the second, (2 capacity / WIDTH, WIDTH), or (0, WIDTH); spreads: how far beside each edge of the path all is to be free
    too, shape (n - 1, n_dof), or (0, n_dof); path: (capacity, n_dof); known: (1, capacity), 0 at first; state: (2, N_STATE) whole
    numbers, of the search and of the shortening. If there are points already, there is no search. Returns what ``grow_trees`` or
    ``shorten_path`` does; NO_ROOM if there is not room for the path.
    """
    scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch)
    edges, steps = edges_of(scene, settings, space), np.empty((4, max(1, space.shape[1])))
    search, shortening = state[0], state[1]
    if shortening[layout.POINTS] == 0:
        if search[layout.JOINED] == 0:
            code = grow_trees(edges, samples, start_rows, goal_rows, parents, radii, costs, steps, search)
            if code != layout.SOLVED:
                return code
        n = write_found(start_rows, goal_rows, parents, space, steps[0], path, search)
        if n < 0:
            return layout.NO_ROOM
        shortening[layout.POINTS], shortening[layout.ROWS] = n, rows_for(n)
        left = max(1, search[layout.UNTIL] - search[layout.CHECKS])
        shortening[layout.UNTIL] = max(shortening[layout.UNTIL], shortening[layout.CHECKS] + left)
    if shortening[layout.PASS] == layout.AS_FOUND:
        return layout.SOLVED
    points = path[: shortening[layout.ROWS]]
    code = shorten_path(straight_edges_of(edges), points, known, spreads, steps, shortening)
    if code != layout.PAUSED:
        drop_repeats(points, shortening)
    return code


@kernel
def grow_trees(edges, samples, start_rows, goal_rows, parents, radii, costs, steps, state):
    """Search on until the trees are joined, or state[UNTIL] edges were checked, or nodes or samples run out.

    Returns SOLVED, PAUSED, FULL or NO_SAMPLE; if solved, state[JOINED_START] and state[JOINED_GOAL] are the nodes that join.
    """
    while state[layout.CHECKS] < state[layout.UNTIL]:
        if state[layout.DIRECT] < state[layout.GOALS]:
            if joins_directly(edges, start_rows, goal_rows, steps, state):
                return layout.SOLVED
            continue
        if max(state[layout.STARTS], state[layout.GOALS]) + edges.settings[layout.ROOM] > parents.shape[1]:
            return layout.FULL
        if state[layout.SAMPLE] - state[layout.FIRST_SAMPLE] >= samples.shape[0]:
            return layout.NO_SAMPLE
        if costs.shape[0] > 0:
            if iterate_cheaper(edges, samples, start_rows, goal_rows, parents, radii, costs, steps, state):
                return layout.SOLVED
        elif iterate(edges, samples, start_rows, goal_rows, parents, radii, steps, state):
            return layout.SOLVED
    return layout.PAUSED


@kernel
def joins_directly(edges, start_rows, goal_rows, steps, state):
    """Whether the straight edge from the first start to the next node of the second tree is free: at first to each goal."""
    goal = state[layout.DIRECT]
    state[layout.DIRECT] += 1
    read_node(start_rows, 0, steps[0])
    read_node(goal_rows, goal, steps[1])
    write_step(steps[0], steps[1], 1.0, edges.space, steps[2])
    state[layout.CHECKS] += 1
    if not is_free(edges, steps[0], steps[2], edges.no_spread):
        return False
    state[layout.JOINED_START], state[layout.JOINED_GOAL], state[layout.JOINED] = 0, goal, 1
    return True


@kernel
def iterate(edges, samples, start_rows, goal_rows, parents, radii, steps, state):
    """Steps 2 to 5; whether the trees are joined."""
    own = next_tree(state)
    rows, others = (start_rows, goal_rows) if own == 0 else (goal_rows, start_rows)
    settings, space = edges.settings, edges.space
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
    state[layout.CHECKS] += 1
    extended = is_free(edges, at, new, edges.no_spread)
    radii[own, near] = adapted_domain(
        radii[own, near], extended, settings[layout.DOMAIN], settings[layout.LEAST_DOMAIN], settings[layout.ADAPTATION]
    )
    state[layout.FAILED + own] = 0 if extended else state[layout.FAILED + own] + 1
    if not extended:
        return False
    node = add_node(rows, parents, radii, own, state, new, near, radii[own, near])
    other = connect(edges, others, parents, radii, 1 - own, steps, state)
    if other < 0:
        return False
    state[layout.JOINED_START], state[layout.JOINED_GOAL] = (node, other) if own == 0 else (other, node)
    state[layout.JOINED] = 1
    return True


@kernel
def connect(edges, rows, parents, radii, tree, steps, state):
    """Step from the nearest node of a tree to the configuration steps[2], as long as edges are free; its node, or -1."""
    settings, space = edges.settings, edges.space
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
        state[layout.CHECKS] += 1
        if not is_free(edges, at, new, edges.no_spread):
            return -1
        node = add_node(rows, parents, radii, tree, state, new, node, np.inf)
        if share == 1.0:
            return node
        for k in range(space.shape[1]):
            at[k] = new[k]
    return -1
