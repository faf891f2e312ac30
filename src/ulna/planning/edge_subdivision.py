"""Divides the edges of a path along tight constraints, so that a motion that leaves the path a little keeps them too.

A search makes its edges as long as a tolerance allows, so that between its ends an edge uses nearly all of it. A motion with a
limit of jerk leaves the path, and would have to stop at each point. Half an edge uses a quarter of that, since a curve leaves a
chord by the square of its length.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Records
from ulna.kernels.planning.constraint_records import Constraints, Entry
from ulna.kinematics.tree import Tree
from ulna.planning.constraint_table import frozen, shares_of
from ulna.planning.entries import keeping
from ulna.planning.space import Space

Array = NDArray[np.float64]
TIGHT = 1.5e-3  # [m or rad]: edges along tighter constraints are divided; for 1 mrad of an orientation it is sqrt(2) mrad
_USED = 0.25  # of a tolerance, by an edge
_EXACT = 0.01  # of a tolerance: how near to the middle of it points are projected
_MAX_POINTS = 20_000
_MAX_HALVINGS = 8


def finer(path: Array, keeps: Constraints, tree: Tree, space: Space) -> Array:
    """A path, shape (n, n_dof), with the same ends, whose points are on the constraints, and whose edges use little of them."""
    allowed = keeps.allowed.copy()
    for name in ("away", "chord", "slack"):
        allowed[name] *= _EXACT
    exact = frozen(keeps._replace(allowed=allowed))
    table, path = space.table.copy(), path.copy()
    if len(path) > 2:
        path[1:-1] = _projected(path[1:-1], exact, tree, table)
    for _ in range(_MAX_HALVINGS):
        long = np.flatnonzero(shares_of(keeps, tree, path) > _USED)
        if not len(long) or len(path) + len(long) > _MAX_POINTS:
            break
        path = np.insert(path, long + 1, _projected(0.5 * (path[long] + path[long + 1]), exact, tree, table), axis=0)
    return path


def _projected(q: Array, keeps: Constraints, tree: Tree, table: Records[Entry]) -> Array:
    q = np.ascontiguousarray(q)
    keeping.project_each(tree.joints, keeps, table, q)
    return q
