"""Searches for a path with two trees, and shortens it: the one entry of planning.

All that a search depends on is in arrays that the caller owns. So it may be ended after any iteration and go on in another call,
and its bits do not depend on where. There is no clock in it: the samples are given, and the budget is a number of edges.
"""

import numpy as np

from ulna.drivers.carried import carried_by
from ulna.drivers.continuous import interval_work
from ulna.drivers.planning.aorrtc import iterate_cheaper
from ulna.drivers.planning.edge import EdgeContext, without_turns
from ulna.drivers.planning.keeping import CONSTRAINTS, keeping_of
from ulna.drivers.planning.rrt_connect import iterate, joins_directly
from ulna.drivers.planning.shortening import shorten_path
from ulna.drivers.planning.tree import drop_repeats, rows_for, write_found
from ulna.engine.decorators import entry, kernel
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRICES, MATRIX, NONE, SCENES, Array, Group
from ulna.kernels.collision.ball_motion import world_rounding
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning.constraint_records import Entry
from ulna.kernels.planning.search_records import (
    AORRTC,
    FULL,
    NO_ROOM,
    NO_SAMPLE,
    PAUSED,
    SOLVED,
    Path,
    SearchSettings,
    SearchState,
    SearchTables,
    ShorteningState,
    Trees,
)

_SEARCH = Group((Array(SearchSettings, 1, constant=True), Array(Entry, 1), MATRIX, Array(SearchState, 1)), SearchTables)
_TREES = Group((MATRICES, INDEX_ROWS, MATRIX, MATRICES, MATRICES), Trees)
_PATH = Group((MATRIX, INDICES, MATRIX, Array(ShorteningState, 1)), Path)


@entry(*((Group(scene, Scene), keeps, _SEARCH, _TREES, _PATH) for scene in SCENES for keeps in (NONE, CONSTRAINTS)))
def plan_slice(scene, keeps, tables, trees, path):
    """Go on with a search, and then with the shortening of the path, each until ``until`` of its state edges were checked.

    It is one entry, since each compiles what decides whether an edge is free, which takes longest, and since a call takes as long
    as an edge.

    scene: a ``Scene``; keeps: ``Constraints``, or None; tables: ``SearchTables``; trees: ``Trees``; path: a
    ``Path``. If that has waypoints already, there is no search. Returns what ``grow_trees`` or ``shorten_path`` does; NO_ROOM if
    there is not room for the path.
    """
    settings, space, search, shortening = tables.settings[0], tables.space, tables.state[0], path.state[0]
    n_dof, of_world, keeping = space.shape[0], world_rounding(scene), keeping_of(scene.joints, keeps, space)
    carried, work, no_spread, steps = carried_by(scene), interval_work(n_dof), np.zeros(n_dof), np.empty((4, max(1, n_dof)))
    context = EdgeContext(scene, carried, work, settings, space, of_world, no_spread, keeping)
    if shortening.points == 0:
        if not search.joined:
            code = grow_trees(context, tables.samples, trees, steps, search)
            if code != SOLVED:
                return code
        n = write_found(trees, space, steps[0], path.waypoints, search)
        if n < 0:
            return NO_ROOM
        shortening.points, shortening.capacity = n, rows_for(n)
        left = max(1, search.until - search.checks)
        shortening.until = max(shortening.until, shortening.checks + left)
    straight = EdgeContext(scene, carried, work, settings, without_turns(space), of_world, no_spread, keeping)
    code = shorten_path(straight, path, steps, shortening)
    if code != PAUSED:
        drop_repeats(path.waypoints, shortening)
    return code


@kernel
def grow_trees(context, samples, trees, steps, state):
    """Search on until the trees are joined, or ``state.until`` edges were checked, or nodes or samples run out.

    Returns SOLVED, PAUSED, FULL or NO_SAMPLE.
    """
    capacity = trees.parents.shape[1]
    while state.checks < state.until:
        if state.direct < state.nodes[1]:
            if joins_directly(context, trees, steps, state):
                return SOLVED
            continue
        if max(state.nodes[0], state.nodes[1]) + context.settings.max_nodes > capacity:
            return FULL
        if state.sample - state.first_sample >= samples.shape[0]:
            return NO_SAMPLE
        if state.algorithm == AORRTC:
            if iterate_cheaper(context, samples, trees, steps, state):
                return SOLVED
        elif iterate(context, samples, trees, steps, state):
            return SOLVED
    return PAUSED
