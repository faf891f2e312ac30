"""Searches for a path with two trees, and shortens it: the one entry of planning.

All that a search depends on is in arrays that the caller owns. So it may be ended after any iteration and go on in another call,
and its bits do not depend on where. There is no clock in it: the samples are given, and the budget is a number of edges.
"""

import numpy as np

from ulna.drivers.planning.aorrtc import iterate_cheaper
from ulna.drivers.planning.edge import context_of, without_turns
from ulna.drivers.planning.rrt_connect import iterate, joins_directly
from ulna.drivers.planning.shortening import shorten_path
from ulna.drivers.planning.tree import drop_repeats, rows_for, write_found
from ulna.engine.decorators import entry, kernel
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRICES, MATRIX, NONE, NUMBERS, SCENES, TABLE
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.planning_layout import Path, Trees

_TREES = MATRICES, INDEX_ROWS, MATRIX, MATRICES, MATRICES  # the types of ``Trees``
_PATH = MATRIX, INDICES, MATRIX  # and of a ``Path``


@entry(*((*scene, keeps, NUMBERS, MATRIX, MATRIX, *_TREES, *_PATH, INDEX_ROWS) for scene in SCENES for keeps in (NONE, TABLE)))
def plan_slice(
    joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch,
    keeps, settings, space, samples, rows, parents, radii, costs, refused, waypoints, known, spreads, state,
):  # fmt: skip
    """Go on with a search, and then with the shortening of the path, until state[0, UNTIL] or state[1, UNTIL] edges were checked.

    It is one entry, since each compiles what decides whether an edge is free, which takes longest, and since a call takes as long
    as an edge. It is called with a ``Scene``, ``Trees`` and a ``Path``, each with a star.

    keeps: the constraints (``planning_layout``), or None; samples: (n, n_dof or more) of numbers in [0, 1), the
    first that of index state[0, FIRST_SAMPLE]; state: (2, N_STATE) whole numbers, of the search and of the shortening. If there
    are waypoints already, there is no search. Returns what ``grow_trees`` or ``shorten_path`` does; NO_ROOM if there is not room
    for the path.
    """
    scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch)
    trees, path = Trees(rows, parents, radii, costs, refused), Path(waypoints, known, spreads)
    context, steps = context_of(scene, settings, space, keeps), np.empty((4, max(1, space.shape[1])))
    search, shortening = state[0], state[1]
    if shortening[layout.POINTS] == 0:
        if search[layout.JOINED] == 0:
            code = grow_trees(context, samples, trees, steps, search)
            if code != layout.SOLVED:
                return code
        n = write_found(trees, space, steps[0], path.waypoints, search)
        if n < 0:
            return layout.NO_ROOM
        shortening[layout.POINTS], shortening[layout.ROWS] = n, rows_for(n)
        left = max(1, search[layout.UNTIL] - search[layout.CHECKS])
        shortening[layout.UNTIL] = max(shortening[layout.UNTIL], shortening[layout.CHECKS] + left)
    code = shorten_path(without_turns(context), path, steps, shortening)
    if code != layout.PAUSED:
        drop_repeats(path.waypoints, shortening)
    return code


@kernel
def grow_trees(context, samples, trees, steps, state):
    """Search on until the trees are joined, or state[UNTIL] edges were checked, or nodes or samples run out.

    Returns SOLVED, PAUSED, FULL or NO_SAMPLE; if solved, state[JOINED_START] and state[JOINED_GOAL] are the nodes that join.
    """
    capacity = trees.parents.shape[1]
    most = context.settings[layout.ROOM] * context.settings[layout.NODES_A_STEP]
    while state[layout.CHECKS] < state[layout.UNTIL]:
        if state[layout.DIRECT] < state[layout.GOALS]:
            if joins_directly(context, trees, steps, state):
                return layout.SOLVED
            continue
        if max(state[layout.STARTS], state[layout.GOALS]) + most > capacity:
            return layout.FULL
        if state[layout.SAMPLE] - state[layout.FIRST_SAMPLE] >= samples.shape[0]:
            return layout.NO_SAMPLE
        if state[layout.ALGORITHM] == layout.AORRTC:
            if iterate_cheaper(context, samples, trees, steps, state):
                return layout.SOLVED
        elif iterate(context, samples, trees, steps, state):
            return layout.SOLVED
    return layout.PAUSED
