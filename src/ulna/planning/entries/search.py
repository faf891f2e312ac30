"""Searches for a path with two trees and shortens it, in slices.

The caller owns all arrays of a search. So it may end after any iteration and continue in another call, with the same result bit
for bit. It uses no clock: the samples are given, and the budget is a number of edges.
"""

import numpy as np

from ulna.collision.entries.continuous import edge_check_of
from ulna.engine.decorators import entry
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRICES, MATRIX, NONE, Array, Group
from ulna.kernels.collision.scene import BOXES, SHAPES
from ulna.kernels.planning.constraint_records import Entry
from ulna.planning.entries.aorrtc import grow_cheaper
from ulna.planning.entries.edge import EdgeContext, drop_periods
from ulna.planning.entries.keeping import CONSTRAINTS, make_keeping
from ulna.planning.entries.rrt_connect import grow_trees
from ulna.planning.entries.search_records import (
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
from ulna.planning.entries.shortening import Cut, shorten_path
from ulna.planning.entries.tree import Steps, drop_repeats, rows_for, write_found

_SEARCH = Group((Array(SearchSettings, 1, constant=True), Array(Entry, 1), MATRIX, Array(SearchState, 1)), SearchTables)
_TREES = Group((MATRICES, INDEX_ROWS, MATRIX, MATRICES, MATRICES), Trees)
_PATH = Group((MATRIX, INDICES, MATRIX, Array(ShorteningState, 1)), Path)


@entry(*((scene, keeps, _SEARCH, _TREES, _PATH) for scene in (BOXES, SHAPES) for keeps in (NONE, CONSTRAINTS)))
def plan_slice(scene, keeps, tables, trees, path):
    """Continue a search, then the shortening of its path, until ``state.until`` edges are checked in each.

    Both are one entry for two reasons. Each would compile the edge checks, which take longest; and a call takes as long as a
    check.

    scene: a ``Scene``; keeps: ``Constraints``, or None; tables: ``SearchTables``; trees: ``Trees``; path: a ``Path``. A path that
    already has waypoints is only shortened. Returns a code of ``grow_trees`` or ``shorten_path``; NO_ROOM if the path lacks room.
    """
    settings, space, search, shortening = tables.settings[0], tables.space, tables.state[0], path.state[0]
    n_dof, keeping = space.shape[0], make_keeping(scene.joints, keeps, space)
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
    straight = EdgeContext(check, settings, drop_periods(space), no_spread, keeping)
    code = shorten_path(straight, path, cut, shortening)
    if code != PAUSED:
        drop_repeats(path.waypoints, shortening)
    return code
