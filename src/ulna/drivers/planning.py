"""Grows two trees towards each other until an edge joins them, and shortens a path. Used by ``ulna.planning``.

RRT-Connect (Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA 2000), with the domains
of Jaillet et al. (Adaptive tuning of the sampling domain for dynamic-domain RRTs, IROS 2005):

1. If the straight edge from the start to a goal is free, that is the path.
2. Take the next sample; unless one tree has twice as many nodes as the other, the trees change roles.
3. Find the nearest node of the first tree. If the sample lies outside its domain, take the next sample.
4. Step from the node towards the sample, by at most RANGE. If the edge is free, its end is a new node, else the node's domain
   shrinks.
5. Step from the nearest node of the second tree towards the new node, again and again, until it is reached, which joins the
   trees, or an edge is not free.

All that a search knows is in arrays that the caller owns. So it may be ended after any iteration and go on in another call, and
its bits do not depend on where. There is no clock in it: the samples are given, and the budget is a number of edges.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.drivers.free_edge import edge_is_free, edge_is_free_at_samples, free_edge_work, interval_work
from ulna.engine.decorators import entry, routine, workspace
from ulna.engine.lanes import lane_of
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRIX, NUMBERS, SCENES, TRUTH_ROWS
from ulna.engine.width import WIDTH
from ulna.kernels.collision.continuous import world_rounding
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.space import adapted_domain, distance, nearest_in_lanes, write_step

N_ATTEMPTS = 48  # of pass 2
N_HALVINGS = 3  # how near to a corner its cut may be: at 1/2, 1/4, 1/8 of its edges
WORTH_A_CUT = 1e-3  # of the length of a path: what gains less is not tried
_FIRST_SHARE, _SECOND_SHARE = 0.7548776662466927, 0.5698402909980532  # of the plastic number: Roberts's sequence R2 (2018)
_MORE = (TRUTH_ROWS, NUMBERS, MATRIX, MATRIX, MATRIX, MATRIX, INDEX_ROWS, MATRIX, MATRIX, INDICES)


class Edges(NamedTuple):
    """What it takes to decide whether an edge is free."""

    scene: Scene
    carried: NamedTuple
    work: tuple
    settings: NDArray
    space: NDArray
    of_world: float
    no_spread: NDArray


@workspace
def edges_of(scene, may_touch, settings, space):
    """The workspaces of a scene."""
    carried, work = free_edge_work(scene, may_touch), interval_work(scene, space.shape[1])
    return Edges(scene, carried, work, settings, space, world_rounding(scene), np.zeros(space.shape[1]))


@routine
def is_free(edges, q_a, q_b, spread):
    """Whether all within ``spread`` of the edge from q_a to q_b is free: certainly, or at samples, as the settings say."""
    settings, sampled = edges.settings, edges.settings[layout.SAMPLED]
    margin = settings[layout.MARGIN]
    if sampled > 0.0:
        n_blocks = int(np.ceil(distance(q_a, q_b, edges.space) / (sampled * WIDTH)))
        return edge_is_free_at_samples(
            edges.scene, edges.carried, edges.work, q_a, q_b, spread, max(1, n_blocks), margin, edges.of_world
        )
    most = int(settings[layout.MOST_BLOCKS])
    return edge_is_free(
        edges.scene, edges.carried, edges.work, q_a, q_b, spread, settings[layout.RESOLUTION], margin, edges.of_world, most
    )


@entry(*((*scene, *_MORE) for scene in SCENES))
def plan_slice(
    joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed,
    may_touch, settings, space, samples, start_rows, goal_rows, parents, radii, path, state,
):  # fmt: skip
    """Go on with a search, or with the shortening of a path if there is one, until state[UNTIL] edges were checked.

    It is one entry, since each compiles what decides whether an edge is free, which takes longest. With a path, ``samples`` is
    empty, or holds how far beside each of its edges all is to be free too, shape (n - 1, n_dof).

    samples: (n, n_dof) of numbers in [0, 1), the first that of index state[FIRST_SAMPLE]; start_rows, goal_rows: the trees
    (``kernels.planning.space``); parents, radii: (2, capacity), -1 for a root; path: (capacity, n_dof), or (0, n_dof) in a
    search; state: N_STATE whole numbers. Returns what ``grow_trees`` or ``shorten_path`` does.
    """
    scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed)
    edges, steps = edges_of(scene, may_touch, settings, space), np.empty((3, max(1, space.shape[1])))
    if path.shape[0] > 0:
        return shorten_path(edges, path, samples, steps, state)
    return grow_trees(edges, samples, start_rows, goal_rows, parents, radii, steps, state)


@routine
def grow_trees(edges, samples, start_rows, goal_rows, parents, radii, steps, state):
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
        if iterate(edges, samples, start_rows, goal_rows, parents, radii, steps, state):
            return layout.SOLVED
    return layout.PAUSED


@routine
def joins_directly(edges, start_rows, goal_rows, steps, state):
    """Whether the straight edge from the first start to the next goal is free."""
    goal = state[layout.DIRECT]
    state[layout.DIRECT] += 1
    read_node(start_rows, 0, steps[0])
    read_node(goal_rows, goal, steps[1])
    write_step(steps[0], steps[1], 1.0, edges.space, steps[2])
    state[layout.CHECKS] += 1
    if not is_free(edges, steps[0], steps[2], edges.no_spread):
        return False
    state[layout.JOINED_START], state[layout.JOINED_GOAL] = 0, goal
    return True


@routine
def iterate(edges, samples, start_rows, goal_rows, parents, radii, steps, state):
    """Steps 2 to 5; whether the trees are joined."""
    own = state[layout.ACTIVE]
    if state[1 - own] < 2 * state[own]:
        own = 1 - own
        state[layout.ACTIVE] = own
    rows, others = (start_rows, goal_rows) if own == 0 else (goal_rows, start_rows)
    settings, space, sample = edges.settings, edges.space, samples[state[layout.SAMPLE] - state[layout.FIRST_SAMPLE]]
    state[layout.SAMPLE] += 1
    target, at, new = steps[0], steps[1], steps[2]
    for k in range(space.shape[1]):
        target[k] = space[layout.LOW, k] + sample[k] * (space[layout.HIGH, k] - space[layout.LOW, k])
    near = nearest_node(rows, state[own], target, space)
    read_node(rows, near, at)
    way = distance(at, target, space)
    if way > radii[own, near] or way == 0.0:
        return False
    state[layout.ITERATIONS] += 1
    write_step(at, target, min(1.0, settings[layout.RANGE] / way), space, new)
    state[layout.CHECKS] += 1
    extended = is_free(edges, at, new, edges.no_spread)
    radii[own, near] = adapted_domain(
        radii[own, near], extended, settings[layout.DOMAIN], settings[layout.LEAST_DOMAIN], settings[layout.ADAPTATION]
    )
    if not extended:
        return False
    node = add_node(rows, parents, radii, own, state, new, near, radii[own, near])
    other = connect(edges, others, parents, radii, 1 - own, steps, state)
    if other < 0:
        return False
    state[layout.JOINED_START], state[layout.JOINED_GOAL] = (node, other) if own == 0 else (other, node)
    return True


@routine
def connect(edges, rows, parents, radii, tree, steps, state):
    """Step from the nearest node of a tree to the configuration steps[2], as long as edges are free; its node, or -1."""
    settings, space = edges.settings, edges.space
    new, at, goal = steps[0], steps[1], steps[2]
    node = nearest_node(rows, state[tree], goal, space)
    read_node(rows, node, at)
    while True:
        way = distance(at, goal, space)
        if way == 0.0:
            return node
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
    for k in range(n_dof):
        rows[node // WIDTH * n_dof + k, node % WIDTH] = q[k]
    parents[tree, node], radii[tree, node] = parent, radius
    state[tree] += 1
    return node


@routine
def shorten_path(edges, path, spreads, ends, state):
    """Shorten a path in place until nothing is gained, or state[UNTIL] edges were checked.

    path: (capacity, n_dof), of which state[POINTS] are its points. Returns SOLVED, PAUSED or NOT_FREE. The passes:

    1. From each point in turn, go straight to the farthest point that a free edge reaches (Geraerts and Overmars, Creating
       high-quality paths for motion planning, IJRR 2007).
    2. The same between places at shares of the length given by a low-discrepancy sequence.
    3. Cut each corner: between the middles of its two edges, or nearer to it, if that edge is free. What is left of the two edges
       is part of what was free. Twice, and then pass 1 again.
    4. Confirm every edge of the path as it is now. Returns NOT_FREE if one is not free.
    """
    while state[layout.CHECKS] < state[layout.UNTIL]:
        if state[layout.PASS] == layout.CONFIRM:
            if state[layout.AT] >= state[layout.POINTS] - 1:
                return layout.SOLVED
            if not confirms(edges, path, spreads, state):
                return layout.NOT_FREE
        elif not goes_on(edges, path, ends, state):
            state[layout.AT], state[layout.OTHER] = 0, 0
            state[layout.PASS] += 1
    return layout.PAUSED


@routine
def goes_on(edges, path, ends, state):
    """One edge of the pass; whether the pass goes on."""
    if state[layout.PASS] % 4 == 0:
        return jump(edges, path, state)
    if state[layout.PASS] == 1:
        return short_cut(edges, path, ends, state)
    return cut_corner(edges, path, ends, state)


@routine
def confirms(edges, path, spreads, state):
    """Whether the next edge of the path, or what lies within its spread, is free, one way or the other."""
    i = state[layout.AT]
    state[layout.AT] += 1
    state[layout.CHECKS] += 1
    spread = spreads[i] if spreads.shape[0] > 0 else edges.no_spread
    return is_free(edges, path[i], path[i + 1], spread) or is_free(edges, path[i + 1], path[i], spread)


@routine
def jump(edges, path, state):
    """One edge of pass 1; whether the pass goes on."""
    n, i = state[layout.POINTS], state[layout.AT]
    if i >= n - 2:
        return False
    j = n - 1 if state[layout.OTHER] == 0 else state[layout.OTHER]
    state[layout.CHECKS] += 1
    if is_free(edges, path[i], path[j], edges.no_spread):
        replace_points(path, state, i + 1, j, 0)
        j = i + 1
    state[layout.OTHER] = j - 1
    if j - 1 <= i + 1:
        state[layout.AT], state[layout.OTHER] = i + 1, 0
    return True


@routine
def short_cut(edges, path, ends, state):
    """One attempt of pass 2; whether the pass goes on."""
    n, attempt, space = state[layout.POINTS], state[layout.AT], edges.space
    if n < 3 or attempt >= N_ATTEMPTS or n + 2 > path.shape[0]:
        return False
    state[layout.AT] += 1
    total = length_of(path, n, space)
    x, y = (0.5 + attempt * _FIRST_SHARE) % 1.0, (0.5 + attempt * _SECOND_SHARE) % 1.0
    i, before = write_place(path, n, min(x, y) * total, space, ends[0])
    j, after = write_place(path, n, max(x, y) * total, space, ends[1])
    if i == j or distance(ends[0], ends[1], space) > after - before - WORTH_A_CUT * total:
        return True
    state[layout.CHECKS] += 1
    if is_free(edges, ends[0], ends[1], edges.no_spread):
        replace_points(path, state, i + 1, j + 1, 2)
        write_point(path, i + 1, ends[0])
        write_point(path, i + 2, ends[1])
    return True


@routine
def cut_corner(edges, path, ends, state):
    """One edge of pass 3; whether the pass goes on."""
    n, i, space = state[layout.POINTS], state[layout.AT] + 1, edges.space
    if i >= n - 1 or n + 1 > path.shape[0]:
        return False
    share = 0.5 / (1 << state[layout.OTHER])  # a power would call exp2, which is not in the wheel
    write_step(path[i], path[i - 1], share, space, ends[0])
    write_step(path[i], path[i + 1], share, space, ends[1])
    around = share * (distance(path[i - 1], path[i], space) + distance(path[i], path[i + 1], space))
    if around - distance(ends[0], ends[1], space) < WORTH_A_CUT * length_of(path, n, space):
        state[layout.AT], state[layout.OTHER] = i, 0
        return True
    state[layout.CHECKS] += 1
    if is_free(edges, ends[0], ends[1], edges.no_spread):
        replace_points(path, state, i, i + 1, 2)
        write_point(path, i, ends[0])
        write_point(path, i + 1, ends[1])
        state[layout.AT], state[layout.OTHER] = i + 1, 0
    elif state[layout.OTHER] + 1 < N_HALVINGS:
        state[layout.OTHER] += 1
    else:
        state[layout.AT], state[layout.OTHER] = i, 0
    return True


@routine
def replace_points(path, state, i, j, n_new):
    """Make room for n_new points in place of the points i to j - 1 of a path."""
    n, shift = state[layout.POINTS], n_new - (j - i)
    for m in range(n - j):
        source = n - 1 - m if shift > 0 else j + m
        for k in range(path.shape[1]):
            path[source + shift, k] = path[source, k]
    state[layout.POINTS] = n + shift


@routine
def write_point(path, i, q):
    """Write a configuration to place i of a path."""
    for k in range(path.shape[1]):
        path[i, k] = q[k]


@routine
def length_of(path, n, space):
    """The length of the first n points of a path."""
    total = 0.0
    for i in range(n - 1):
        total += distance(path[i], path[i + 1], space)
    return total


@routine
def write_place(path, n, at, space, q):
    """Write the configuration at a length of a path to q; the edge on which it lies, and its length from the start."""
    done = 0.0
    for i in range(n - 1):
        step = distance(path[i], path[i + 1], space)
        if at <= done + step or i == n - 2:
            write_step(path[i], path[i + 1], min(1.0, (at - done) / step) if step > 0.0 else 0.0, space, q)
            return i, at
        done += step
    return 0, 0.0
