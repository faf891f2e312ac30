"""Bounds the violation of constraints on an edge, and projects configurations onto constraints.

The bound is for the largest share of its tolerance that any constraint uses on the edge (``kernels.planning.keeping``); 1 is the
limit. An edge is divided into intervals as in ``collision.entries.continuous``. The algorithm maintains a level, at least
``apart`` above each share found so far:

1. An interval whose bound is at most the level is finished. Other intervals are split.
2. When no interval is left, the level is the bound for the whole edge. It is at most ``apart`` above the true value.

Starting with the level 0, it measures an edge. Starting with 1, and ending once the level exceeds 1, it decides whether the edge
satisfies the constraints. Then a share up to 1 - ``apart`` is certainly accepted, and a share above 1 certainly refused.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.entries.carried import steps_of
from ulna.collision.entries.continuous import BREADTH, interval_work, split_next, write_places
from ulna.engine.decorators import entry, kernel, routine, shared_routine, workspace
from ulna.engine.lanes import WIDTH, any_lane, empty_rows, load, splat, store
from ulna.engine.signatures import MATRIX, NUMBER, NUMBERS, TABLE, Array, Group
from ulna.kernels.chain.poses import tree_poses
from ulna.kernels.collision.ball_motion import INSTANT, write_steps, write_twists
from ulna.kernels.collision.scene import Edge
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.planning.constraint_records import Constraint, Constraints, Entry
from ulna.kernels.planning.keeping import keep_shares, write_keep_bounds
from ulna.kernels.planning.projection import project_step

APART = 1e-4  # share of a tolerance: an edge nearer to the limit may be refused
_SHORTEST = 1e-13  # half-width of the shortest interval, which is not split
_MAX_STEPS = 12  # maximum steps of a projection
_INF = float("inf")


class Bound(NamedTuple):
    """The required precision of a bound, and the range of interest."""

    level: float
    """The minimum of the bound."""
    apart: float
    """The largest excess of the bound over the true value; relative for values above 1."""
    most: float
    """The value above which the computation ends."""


class Moving(NamedTuple):
    """The joints at eight configurations of an edge, with the names and shapes of ``Carried``."""

    steps: NDArray
    speeds: NDArray
    """The speeds of the origins of each constraint's two frames, shape (2 n, n_joints + 1)."""
    bends: NDArray
    joint_rows: NDArray
    twist_rows: NDArray


class Keeping(NamedTuple):
    """Constraints with their workspaces for bounds and projections."""

    keeps: Constraints
    """The constraints."""
    slacks: NDArray
    """The additions for rounding and the spread (``kernels.planning.keeping``), shape (n, 3)."""
    share_rows: NDArray
    """Shares at the middles of eight intervals, and their bounds: two rows."""
    moving: Moving
    bound_rows: NDArray
    """Lower bounds of q, then upper bounds, 2 n_dof rows; no rows without projections."""
    jacobian_rows: NDArray
    """A Jacobian, 6 n_dof rows."""
    system_rows: NDArray
    """A damped system."""
    way_rows: NDArray
    """Eight configurations of a step, n_dof rows."""
    curve: NDArray
    """The waypoints of a path along the constraints, and three more rows, shape (11, n_dof)."""
    sample_rows: NDArray
    """Eight projected samples, n_dof rows."""
    sampled: NDArray
    """The index of the block of eight samples in ``sample_rows``, shape (1,)."""


@workspace
def make_keeping(joints, keeps, space):
    """Constraints with their workspaces, or None. space: the range of projected configurations."""
    if keeps is None:
        return None
    return make_workspace(joints, keeps, make_bound_rows(space))


@workspace
def make_bound_rows(space):
    """Lower bounds of q, then upper bounds, 2 n_dof rows."""
    n_dof = space.shape[0]
    bound_rows = empty_rows(2 * n_dof)
    for k in range(n_dof):
        turns = space[k].period > 0.0
        for lane in range(WIDTH):
            bound_rows[k, lane] = -_INF if turns else space[k].low
            bound_rows[n_dof + k, lane] = _INF if turns else space[k].high
    return bound_rows


@workspace
def make_workspace(joints, keeps, bound_rows):
    """Constraints with their workspaces. bound_rows: bounds of q; no rows without projections."""
    n, n_joints, n_dof = keeps.allowed.shape[0], joints.shape[0], bound_rows.shape[0] // 2
    moving = Moving(
        steps_of(joints), np.empty((2 * n, n_joints + 1)), np.empty((2 * n, n_joints + 1)),
        empty_rows(12 * n_joints), empty_rows(6 * n_joints),
    )  # fmt: skip
    return Keeping(
        keeps, np.empty((n, 3)), empty_rows(2), moving,
        bound_rows, empty_rows(6 * n_dof), empty_rows(N_SYSTEM), empty_rows(n_dof),
        np.empty((WIDTH + 3, n_dof)), empty_rows(n_dof), np.full(1, -1),
    )  # fmt: skip


CONSTRAINTS = Group((TABLE, Array(Constraint, 1, constant=True)), Constraints)


@entry((TABLE, CONSTRAINTS, MATRIX, MATRIX, Group((NUMBER, NUMBER, NUMBER), Bound), NUMBERS))
def shares_of_edges(joints, keeps, q_a, q_b, bound, shares):
    """Write ``greatest_share`` of each edge, from a row of q_a to a row of q_b, to shares, shape (n,)."""
    keeping, work, no_spread = make_workspace(joints, keeps, empty_rows(0)), interval_work(q_a.shape[1]), np.zeros(q_a.shape[1])
    for e in range(q_a.shape[0]):
        shares[e] = greatest_share(joints, keeping, work, Edge(q_a[e], q_b[e], no_spread), bound)
    return True


@entry((TABLE, CONSTRAINTS, Array(Entry, 1), MATRIX))
def project_each(joints, keeps, space, q):
    """Project each row of q, shape (n, n_dof), onto the constraints by at most _MAX_STEPS steps. space: its bounds."""
    n, n_dof = q.shape
    keeping, no_spread, rows = make_keeping(joints, keeps, space), np.zeros(n_dof), empty_rows(n_dof)
    for first in range(0, n, WIDTH):
        for j in range(n_dof):
            for lane in range(WIDTH):
                rows[j, lane] = q[min(first + lane, n - 1), j]
        project(joints, keeping, q[first], no_spread, rows)
        for j in range(n_dof):
            for lane in range(min(WIDTH, n - first)):
                q[first + lane, j] = rows[j, lane]
    return True


@kernel
def satisfies_all(joints, keeping, work, q_a, q_b, spread):
    """Whether an edge, with all within ``spread`` of it, certainly satisfies the constraints, if there are any."""
    if keeping is None:
        return True
    return greatest_share(joints, keeping, work, Edge(q_a, q_b, spread), Bound(1.0, APART, 1.0)) <= 1.0


@routine
def greatest_share(joints, keeping, work, edge, bound):
    """An upper bound (``Bound``) of the share of a tolerance that an edge uses, within its spread.

    It is at most ``apart`` above the true value, unless it equals ``level`` or exceeds ``most``. The edge must be in range.
    """
    (q_a, q_b, spread), (level, apart, most) = edge, bound
    _, lane_rows, waiting, _ = work
    write_steps(joints, q_a, q_b, spread, keeping.moving.steps)
    write_keep_bounds(joints, keeping.keeps, keeping.moving, keeping.slacks)
    waiting[0, 0], waiting[0, 1] = 0.5, 0.5
    oldest, newest = 0, 1
    while oldest < newest:
        n, oldest, newest = split_next(waiting, oldest, newest, lane_rows, BREADTH)
        write_places(q_a, q_b, work)
        write_shares(joints, keeping, work[0], load(lane_rows, 1) + INSTANT)
        for lane in range(WIDTH // n * n):
            share = keeping.share_rows[0, lane]
            if not share + apart * max(1.0, share) <= level:
                level = share + apart * max(1.0, share)
        if not level <= most:
            return level
        for lane in range(WIDTH // n * n):
            if keeping.share_rows[1, lane] > level:
                if lane_rows[1, lane] <= _SHORTEST:
                    level = keeping.share_rows[1, lane]
                else:
                    waiting[newest, 0], waiting[newest, 1] = lane_rows[0, lane], lane_rows[1, lane]
                    newest += 1
    return level


@shared_routine
def write_shares(joints, keeping, q_rows, half):
    """Write the used shares at eight configurations, and their bounds within ``half``."""
    moving = keeping.moving
    tree_poses(joints, q_rows, moving.joint_rows)
    write_twists(joints, moving, half)
    value, bound = keep_shares(joints, keeping.keeps, keeping.slacks, moving, half, half)
    store(keeping.share_rows, 0, value)
    store(keeping.share_rows, 1, bound)


@routine
def project(joints, keeping, near, no_spread, q_rows):
    """Project eight configurations onto the constraints, within the bounds, by at most _MAX_STEPS steps.

    near: a configuration in range, for bounds of rounding. no_spread: zeros. Their shape is (n_dof,).
    """
    write_steps(joints, near, near, no_spread, keeping.moving.steps)
    write_keep_bounds(joints, keeping.keeps, keeping.moving, keeping.slacks)
    still = splat(0.0, load(q_rows, 0))
    for _ in range(_MAX_STEPS):
        write_shares(joints, keeping, q_rows, still)
        active = load(keeping.share_rows, 0) > 1.0 - APART
        if not any_lane(active):
            return
        for i in range(keeping.keeps.allowed.shape[0]):
            step_towards(joints, keeping, i, active, q_rows)


@routine
def step_towards(joints, keeping, i, active, q_rows):
    """Move the active lanes by one step towards constraint i."""
    tree_poses(joints, q_rows, keeping.moving.joint_rows)
    project_step(joints, keeping, i, active, q_rows)
