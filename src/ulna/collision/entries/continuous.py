"""Continuous collision checking: decides whether an edge is free, and the fraction of it that is.

An edge is q(t) = q_a + t (q_b - q_a), 0 <= t <= 1. Samples of it may all be free although it touches something between them.
Intervals of t are certified instead. Take an interval with middle c and half length h. Taylor's theorem bounds the distance that
a point p of a body moves from its position at c:

    m(h) = h |p'(c)| + h^2 / 2 max |p''|.

p'(c) is exact, and the rates of the joints bound p'' (``kernels.collision.ball_motion``). Let d be the distance of two bodies at
c. If d > m_a(h) + m_b(h), they touch nowhere in the interval: one distance decides on all of its configurations. If d <= 0, they
touch. Otherwise the interval is split. m is about proportional to h, so each half needs about half the distance. Far from
everything, one interval covers the whole edge; at a distance d, intervals are about d / |p'| long. Eight intervals are decided at
once (``kernels.collision.interval``):

1. Eight intervals cover the edge. If something touches at the middle of any, the edge is not free.
2. An interval that is not clear throughout is split: one into eight, two into four each, up to four into two each, to fill the
   lanes. The oldest intervals go first, so a contact in the middle of an edge is found before its ends are refined. Once
   ``BREADTH`` intervals were split, the newest go first. This bounds the memory, however near the edge passes.
3. The edge is free when no interval is left. If nothing moves by the resolution within an interval, it is not split further, and
   the edge is not free. So "free" is certain; "not free" means that the edge touches something or passes within about the
   resolution.

For an edge that is not free, ``free_until`` splits the first interval that is not clear, again and again.

Source: conservative advancement, Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996.
"""

import numpy as np

from ulna.collision.entries.carried import carried_by
from ulna.engine.decorators import entry, kernel, routine, shared_routine, workspace
from ulna.engine.lanes import WIDTH, empty_rows, load, store, zero_rows
from ulna.engine.signatures import INDICES, MATRIX, NUMBER, NUMBERS
from ulna.kernels.collision.ball_motion import INSTANT, fastest_ball, place_balls, world_rounding, write_motion
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.collision_layout import EDGE_CONTACT, EDGE_FREE, EDGE_OUT_OF_RANGE
from ulna.kernels.collision.interval import self_outcome, world_outcome
from ulna.kernels.collision.scene import BOXES, SHAPES, Edge, EdgeCheck, Intervals
from ulna.kernels.spatial.elementary import all_in_range

BREADTH = 512  # intervals
_DEPTH = 128  # halvings of an interval: more than there are floats between 0 and 1


@entry(*((scene, MATRIX, MATRIX, NUMBER, INDICES, NUMBERS) for scene in (BOXES, SHAPES)))
def edges_each(scene, q_a, q_b, resolution, status, contact):
    """Check the edge from each row of q_a to the same row of q_b.

    status, shape (n,), and contact, shape (n,), become EDGE_FREE and 1.0; or EDGE_CONTACT and the free fraction of the edge; or
    EDGE_OUT_OF_RANGE and 0.0.
    """
    check, no_spread = edge_check_of(scene, q_a.shape[1]), np.zeros(q_a.shape[1])
    for e in range(q_a.shape[0]):
        edge = Edge(q_a[e], q_b[e], no_spread)
        if not (all_in_range(edge.q_a) and all_in_range(edge.q_b)):
            status[e], contact[e] = EDGE_OUT_OF_RANGE, 0.0
        elif edge_is_free(check, edge, resolution, 0.0, None, BREADTH):
            status[e], contact[e] = EDGE_FREE, 1.0
        else:
            status[e] = EDGE_CONTACT
            contact[e] = free_until(check, edge, resolution)
    return True


@workspace
def edge_check_of(scene, n_dof):
    """The ``EdgeCheck`` of a scene."""
    return EdgeCheck(scene, carried_by(scene), interval_work(n_dof), world_rounding(scene))


@workspace
def interval_work(n_dof):
    """Room for eight configurations, eight intervals, the waiting intervals, and the stack of the BVH."""
    return (
        zero_rows(max(1, n_dof)),
        empty_rows(3),
        np.empty((BREADTH + WIDTH * _DEPTH, 2)),
        np.empty(STACK, np.int64),
    )


@kernel
def edge_is_free(check, edge, resolution, margin, margins, breadth):
    """Whether an edge is certainly free, and every object of the world is farther away than a margin [m].

    Args:
        check: An ``EdgeCheck``.
        edge: An ``Edge`` whose ends are in range.
        resolution: Length of the motion below which an interval is not split [m].
        margin: Clearance from objects [m].
        margins: Wider margins for some objects (``scene.Margins``), or None.
        breadth: The number of intervals that are split the oldest first, at most BREADTH. With 0, an edge that passes near
            something for long is given up after a few tests at one place.
    """
    joints, carried, (_, lane_rows, waiting, _) = check.scene.joints, check.carried, check.work
    write_motion(joints, edge.q_a, edge.q_b, edge.spread, carried)
    fastest = fastest_ball(joints, carried)
    waiting[0, 0], waiting[0, 1] = 0.5, 0.5
    oldest, newest = 0, 1
    while oldest < newest:
        n, oldest, newest = split_next(waiting, oldest, newest, lane_rows, breadth)
        if outcome_at(check, edge, INSTANT, margin, margins, stop_at_contact=True):
            return False
        for lane in range(WIDTH // n * n):
            if lane_rows[2, lane] == 0.0:
                if 2.0 * lane_rows[1, lane] * fastest <= resolution:
                    return False
                waiting[newest, 0], waiting[newest, 1] = lane_rows[0, lane], lane_rows[1, lane]
                newest += 1
    return True


@kernel
def free_until(check, edge, resolution):
    """The fraction of an edge that is certainly free, after ``edge_is_free`` returned False for the same check."""
    _, lane_rows, waiting, _ = check.work
    fastest, at_most = fastest_ball(check.scene.joints, check.carried), 0.0
    for lane in range(WIDTH):
        if lane_rows[2, lane] == 0.0:  # one of these contains the contact
            at_most = max(at_most, lane_rows[0, lane])
    waiting[0, 0], waiting[0, 1], n = 0.5, 0.5, 1
    while n > 0:
        n -= 1
        if waiting[n, 0] - waiting[n, 1] >= at_most:
            return at_most
        split(waiting, n, 1, lane_rows)
        outcome_at(check, edge, INSTANT, 0.0, None, stop_at_contact=False)
        for back in range(WIDTH):
            lane = WIDTH - 1 - back
            if lane_rows[2, lane] == 0.0:
                waiting[n, 0], waiting[n, 1] = lane_rows[0, lane], lane_rows[1, lane]
                n += 1
        if n > 0 and 2.0 * waiting[n - 1, 1] * fastest <= resolution:
            return min(at_most, waiting[n - 1, 0] - waiting[n - 1, 1])
    return at_most


@kernel
def split_next(waiting, oldest, newest, lane_rows, breadth):
    """Split the next intervals, the oldest first, or the newest once ``breadth`` intervals wait.

    Returns the number of split intervals, and the new range of waiting ones.
    """
    n = min(newest - oldest, WIDTH // 2)
    if newest < breadth:
        split(waiting, oldest, n, lane_rows)
        return n, oldest + n, newest
    split(waiting, newest - n, n, lane_rows)
    return n, oldest, newest - n


@routine
def split(waiting, first, n, lane_rows):
    """Split n waiting intervals, 1 to 4, into eight: write their middles and half lengths.

    ``first`` is the first of the n. The last parts are repeats where n does not divide eight.
    """
    share = WIDTH // n
    for lane in range(WIDTH):
        i, part = first + min(lane // share, n - 1), lane % share
        half = waiting[i, 1] / share
        lane_rows[0, lane], lane_rows[1, lane] = waiting[i, 0] + (2 * part + 1 - share) * half, half


@kernel
def write_places(q_a, q_b, work):
    """Write the configurations at the middles of eight intervals of an edge."""
    q_rows, t = work[0], load(work[1], 0)
    for k in range(q_a.shape[0]):
        store(q_rows, k, t * (q_b[k] - q_a[k]) + q_a[k])


@shared_routine
def outcome_at(check, edge, instant, margin, margins, stop_at_contact):
    """Whether something touches at the middles of eight intervals. ``lane_rows`` gets 1 for each clear interval.

    instant: A length to add to their half lengths; 0 if these are 0, so that nothing moves. stop: Whether a contact ends the
    search. If it does, lanes marked clear need not be clear.
    """
    scene, carried, (q_rows, lane_rows, _, stack) = check.scene, check.carried, check.work
    half, is_instant = load(lane_rows, 1) + instant, instant == 0.0
    write_places(edge.q_a, edge.q_b, check.work)
    like, intervals = load(q_rows, 0), Intervals(half, is_instant, stop_at_contact, margin, margins, check.object_rounding)
    place_balls(scene.joints, q_rows, half, is_instant, carried)
    touches, clear = world_outcome(scene, carried, intervals, stack, like)
    if not touches:
        touches, clear = self_outcome(scene, carried, intervals, clear, like)
    store(lane_rows, 2, clear)
    return touches


@kernel
def edge_is_free_at_samples(check, edge, n_blocks, margin):
    """Whether the robot is free at 8 n_blocks evenly spaced configurations of an edge, the last of them its end.

    Certified intervals cover the samples inside. Intervals are tested as in ``edge_is_free``, as long as each test of eight
    settles more samples than there are lanes.
    """
    _, lane_rows, waiting, _ = check.work
    write_motion(check.scene.joints, edge.q_a, edge.q_b, edge.spread, check.carried)
    waiting[0, 0], waiting[0, 1] = 0.5, 0.5
    oldest, newest, left, settled = 0, 1, WIDTH * n_blocks, WIDTH + 1
    while left > WIDTH and settled > WIDTH and newest < BREADTH:
        n = min(newest - oldest, WIDTH // 2)
        split(waiting, oldest, n, lane_rows)
        oldest, before, left = oldest + n, left, 0
        if outcome_at(check, edge, INSTANT, margin, None, stop_at_contact=True):
            return False
        for lane in range(WIDTH // n * n):
            if lane_rows[2, lane] == 0.0:
                waiting[newest, 0], waiting[newest, 1] = lane_rows[0, lane], lane_rows[1, lane]
                newest += 1
        for i in range(oldest, newest):
            first, end = samples_in(waiting, i, n_blocks)
            left += end - first
        settled = before - left
    n = 0
    for i in range(oldest, newest):
        first, end = samples_in(waiting, i, n_blocks)
        for sample in range(first, end):
            lane_rows[0, n] = sample / (WIDTH * n_blocks)
            n += 1
            if n == WIDTH:
                if touches_at(check, edge, n, margin):
                    return False
                n = 0
    return n == 0 or not touches_at(check, edge, n, margin)


@routine
def samples_in(waiting, i, n_blocks):
    """The samples inside a waiting interval: the first, and the one after the last.

    The 8 n_blocks samples are at multiples of 1 / (8 n_blocks).
    """
    middle, half, n = waiting[i, 0], waiting[i, 1], WIDTH * n_blocks
    return int((middle - half) * n) + 1, int((middle + half) * n) + 1


@kernel
def touches_at(check, edge, n, margin):
    """Whether the robot is not free at any of the first n configurations of eight, n > 0."""
    lane_rows = check.work[1]
    for lane in range(WIDTH):
        lane_rows[0, lane], lane_rows[1, lane] = lane_rows[0, min(lane, n - 1)], 0.0
    touches = outcome_at(check, edge, 0.0, margin, None, stop_at_contact=True)
    for lane in range(WIDTH):
        touches = touches or lane_rows[2, lane] == 0.0
    return touches
