"""Adds solutions that whole turns bring to a limit, as far as their angles are known.

The closed form puts a branch at the limits that it is hardly beyond in the turn that is nearest to a seed. In another turn it may
be hardly beyond a limit as well: there it is a solution of its own, the joint at the limit and the others where they make good
what the pose would be off.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import closed_form
from ulna.ik.following.course import Course
from ulna.ik.turns import TURN
from ulna.kernels.chain.closed_form_layout import AT_LIMIT, ENOUGH, HARDLY_BEYOND

Array = NDArray[np.float64]
_STEPS = 16


def with_solutions_at_limits(course: Course, rows: list[Array]) -> list[Array]:
    """The solutions of each pose (m, n_dof) within the limits, and behind them those that are added."""
    tree, q = course.query.tree, np.concatenate(rows)
    pose = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    for j in np.flatnonzero(course.lifts.lifted).tolist():
        for limit, outwards in ((tree.lower[j], -1.0), (tree.upper[j], 1.0)):
            if not np.isfinite(limit):
                continue
            beyond = outwards * (q[:, j] - limit)
            beyond -= TURN * np.rint(beyond / TURN)
            some = np.flatnonzero((beyond > AT_LIMIT) & (beyond <= HARDLY_BEYOND))
            put, reached = _solved_at(course, pose[some], q[some], j, limit)
            q, pose = np.vstack([q, put[reached]]), np.r_[pose, pose[some[reached]]]
    order = np.argsort(pose, kind="stable")
    return np.split(q[order], np.searchsorted(pose[order], np.arange(1, len(rows))))


def _solved_at(course: Course, pose: NDArray[np.int64], q: Array, j: int, limit: float) -> tuple[Array, NDArray[np.bool_]]:
    """Configurations (m, n_dof) with joint j at a limit, the others by Newton steps, and whether they are solutions."""
    tree, errors = course.query.tree, np.ones(len(pose))
    q = q.copy()
    q[:, j] = limit
    bounds, share = np.r_[tree.lower, tree.upper], 1.0 / course.query.unit
    closed_form.polish_all(tree.chain(course.query.link), course.targets[pose], q, bounds, share, _STEPS, errors)
    return q, (errors <= ENOUGH) & (q[:, j] == limit)
