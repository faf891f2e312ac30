"""Subdivides the edges of a path along tight constraints, so that a jerk-limited motion near the path satisfies them too.

The edges of a search are as long as a tolerance allows: between its ends, an edge uses nearly all of the tolerance. A motion with
a jerk limit leaves the path slightly, so it would have to stop at each point. Half an edge uses a quarter of the tolerance, since
the distance of a curve from its chord is quadratic in the length.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Records
from ulna.kernels.planning.constraint_records import Constraints, Entry
from ulna.kinematics.tree import Tree
from ulna.planning.constraint_table import freeze, tolerance_shares
from ulna.planning.entries import keeping
from ulna.planning.space import Space

Array = NDArray[np.float64]
TIGHT = 1.5e-3  # [m or rad]: edges along tighter constraints are subdivided; an orientation's 1 mrad counts as sqrt(2) mrad
_MAX_SHARE = 0.25  # largest share of a tolerance that an edge may use
_PROJECTION_SHARE = 0.01  # share of a tolerance within which points are projected
_MAX_POINTS = 20_000
_MAX_HALVINGS = 8


def subdivide(path: Array, keeps: Constraints, tree: Tree, space: Space) -> Array:
    """Subdivide a path, shape (n, n_dof): inner points are projected onto the constraints, and edges use little tolerance."""
    allowed = keeps.allowed.copy()
    for name in ("away", "chord", "slack"):
        allowed[name] *= _PROJECTION_SHARE
    exact = freeze(keeps._replace(allowed=allowed))
    table, path = space.table.copy(), path.copy()
    if len(path) > 2:
        path[1:-1] = _project(path[1:-1], exact, tree, table)
    for _ in range(_MAX_HALVINGS):
        long = np.flatnonzero(tolerance_shares(keeps, tree, path) > _MAX_SHARE)
        if not len(long) or len(path) + len(long) > _MAX_POINTS:
            break
        path = np.insert(path, long + 1, _project(0.5 * (path[long] + path[long + 1]), exact, tree, table), axis=0)
    return path


def _project(q: Array, keeps: Constraints, tree: Tree, table: Records[Entry]) -> Array:
    q = np.ascontiguousarray(q)
    keeping.project_each(tree.joints, keeps, table, q)
    return q
