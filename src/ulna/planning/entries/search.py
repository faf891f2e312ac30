"""Searches for a path with two trees, and shortens it: the one entry of planning.

All that a search depends on is in arrays that the caller owns. So it may be ended after any iteration and go on in another call,
and its bits do not depend on where. There is no clock in it: the samples are given, and the budget is a number of edges.
"""

import numpy as np

from ulna.collision.entries.continuous import edge_check_of
from ulna.engine.decorators import entry
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRICES, MATRIX, NONE, Array, Group
from ulna.kernels.collision.scene import BOXES, SHAPES
from ulna.kernels.planning.constraint_records import Entry
from ulna.planning.entries.aorrtc import grow_cheaper
from ulna.planning.entries.edge import EdgeContext, without_turns
from ulna.planning.entries.keeping import CONSTRAINTS, keeping_of
from ulna.planning.entries.rrt_connect import grow_trees
from ulna.planning.entries.shortening import Cut, shorten_path
from ulna.planning.entries.tree import Steps, drop_repeats, rows_for, write_found
from ulna.planning.search_records import (
    AORRTC,
    NO_ROOM,
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


@entry(*((scene, keeps, _SEARCH, _TREES, _PATH) for scene in (BOXES, SHAPES) for keeps in (NONE, CONSTRAINTS)))
def plan_slice(scene, keeps, tables, trees, path):
    """Go on with a search, and then with the shortening of the path, each until ``until`` of its state edges were checked.

    It is one entry, since each compiles what decides whether an edge is free, which takes longest, and since a call takes as long
    as an edge.

    scene: a ``Scene``; keeps: ``Constraints``, or None; tables: ``SearchTables``; trees: ``Trees``; path: a ``Path``. If that has
    waypoints already, there is no search. Returns what ``grow_trees`` or ``shorten_path`` does; NO_ROOM if there is not room for
    the path.
    """
    settings, space, search, shortening = tables.settings[0], tables.space, tables.state[0], path.state[0]
    n_dof, keeping = space.shape[0], keeping_of(scene.joints, keeps, space)
    check, no_spread = edge_check_of(scene, n_dof), np.zeros(n_dof)
    room = np.empty((4, max(1, n_dof)))
    steps, cut = Steps(room[0], room[1], room[2]), Cut(room[0], room[1], room[2], room[3])
    context = EdgeContext(check, settings, space, no_spread, keeping)
    if shortening.points == 0:
        if not search.joined:
            if search.algorithm == AORRTC:
                code = grow_cheaper(context, tables.samples, trees, steps, search)
            else:
                code = grow_trees(context, tables.samples, trees, steps, search)
            if code != SOLVED:
                return code
        n = write_found(trees, space, steps.target, path.waypoints, search)
        if n < 0:
            return NO_ROOM
        shortening.points, shortening.capacity = n, rows_for(n)
        left = max(1, search.until - search.checks)
        shortening.until = max(shortening.until, shortening.checks + left)
    straight = EdgeContext(check, settings, without_turns(space), no_spread, keeping)
    code = shorten_path(straight, path, cut, shortening)
    if code != PAUSED:
        drop_repeats(path.waypoints, shortening)
    return code
