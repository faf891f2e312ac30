"""Bounds by how much an edge leaves its constraints, and projects configurations onto them.

An edge is divided into intervals as in ``collision.entries.continuous``. What is bounded is the greatest share of its tolerance
that any constraint uses on the edge (``kernels.planning.keeping``): 1 is as much as is allowed. A level is kept, from which on
intervals count; it is at all times at least ``apart`` above each share that was seen:

1. An interval whose bound is not above the level is done with. Others are split.
2. The level is the bound of the whole edge when no interval is left. It is more than the truth by ``apart`` at most.

From the level 0 on that measures an edge. From 1 on, with an end as soon as the level is above 1, it decides whether the edge
keeps its constraints: then a share of 1 - ``apart`` is kept for certain, and one above 1 is refused for certain.
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

APART = 1e-4  # of a tolerance: what is nearer to it may be refused
_SHORTEST = 1e-13  # of t: half of an interval that is not split
_MAX_STEPS = 12  # of a projection
_INF = float("inf")


class Bound(NamedTuple):
    """How near a bound of a share has to be to the truth, and where it is of no interest."""

    level: float
    """It is at least this."""
    apart: float
    """By how much it is more than the truth at most; times the share, if that is above 1."""
    most: float
    """From here on the search ends."""


class Moving(NamedTuple):
    """The joints at eight configurations of an edge; the names are those of ``Carried``, and so are the shapes."""

    steps: NDArray
    speeds: NDArray
    """Of the origins of the two frames of each constraint, shape (2 n, n_joints + 1)."""
    bends: NDArray
    joint_rows: NDArray
    twist_rows: NDArray


class Keeping(NamedTuple):
    """Constraints, with room to bound and to project them."""

    keeps: Constraints
    """The constraints."""
    slacks: NDArray
    """What rounding and the spread add to each (``kernels.planning.keeping``), shape (n, 3)."""
    share_rows: NDArray
    """Shares at the middles of eight intervals, and their bounds: two rows."""
    moving: Moving
    bound_rows: NDArray
    """Lower and then upper bounds of q, 2 n_dof rows; so many as q has entries, none if nothing is projected."""
    jacobian_rows: NDArray
    """6 n_dof rows."""
    system_rows: NDArray
    """Those of a damped system."""
    way_rows: NDArray
    """Eight configurations of a step, n_dof rows."""
    curve: NDArray
    """The corners of a way along the constraints, and three more rows, shape (11, n_dof)."""
    sample_rows: NDArray
    """Eight samples, projected, n_dof rows."""
    sampled: NDArray
    """Which eight they are, by an eighth of the first one's number, shape (1,)."""


@workspace
def keeping_of(joints, keeps, space):
    """Constraints with their room, or None. space: where configurations are projected."""
    if keeps is None:
        return None
    return room_of(joints, keeps, bounds_of(space))


@workspace
def bounds_of(space):
    """Lower and then upper bounds of q, 2 n_dof rows."""
    n_dof = space.shape[0]
    bound_rows = empty_rows(2 * n_dof)
    for k in range(n_dof):
        turns = space[k].period > 0.0
        for lane in range(WIDTH):
            bound_rows[k, lane] = -_INF if turns else space[k].low
            bound_rows[n_dof + k, lane] = _INF if turns else space[k].high
    return bound_rows


@workspace
def room_of(joints, keeps, bound_rows):
    """Constraints with their room. bound_rows: of q; none if nothing is projected."""
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
    """Write to shares, shape (n,), the bound of the edge from each row of q_a to that of q_b; see ``greatest_share``."""
    keeping, work, no_spread = room_of(joints, keeps, empty_rows(0)), interval_work(q_a.shape[1]), np.zeros(q_a.shape[1])
    for e in range(q_a.shape[0]):
        shares[e] = greatest_share(joints, keeping, work, Edge(q_a[e], q_b[e], no_spread), bound)
    return True


@entry((TABLE, CONSTRAINTS, Array(Entry, 1), MATRIX))
def project_each(joints, keeps, space, q):
    """Move each row of q, shape (n, n_dof), onto the constraints, as near as _MAX_STEPS get it. space: its bounds."""
    n, n_dof = q.shape
    keeping, no_spread, rows = keeping_of(joints, keeps, space), np.zeros(n_dof), empty_rows(n_dof)
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
def keeps_all(joints, keeping, work, q_a, q_b, spread):
    """Whether all within ``spread`` of an edge certainly keeps the constraints, if there are any."""
    if keeping is None:
        return True
    return greatest_share(joints, keeping, work, Edge(q_a, q_b, spread), Bound(1.0, APART, 1.0)) <= 1.0


@routine
def greatest_share(joints, keeping, work, edge, bound):
    """A bound (``Bound``) of the share of a tolerance that is used on an edge, and within its spread; the edge is in range.

    It is more than the truth by ``apart`` at most, unless it is ``level``, or above ``most``.
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
    """Write the shares that are used at eight configurations, and their bounds within ``half``."""
    moving = keeping.moving
    tree_poses(joints, q_rows, moving.joint_rows)
    write_twists(joints, moving, half)
    value, bound = keep_shares(joints, keeping.keeps, keeping.slacks, moving, half, half)
    store(keeping.share_rows, 0, value)
    store(keeping.share_rows, 1, bound)


@routine
def project(joints, keeping, near, no_spread, q_rows):
    """Move eight configurations onto the constraints, within the bounds, where they are not: as near as _MAX_STEPS get them.

    near: a configuration in range, by which rounding is bounded; no_spread: zeros; shape (n_dof,) each.
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
