"""Probes of kernels: each loads numbers from rows, calls one kernel, and stores its results. See ``kernel_modes``."""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, lane_count, lane_of, load, logical_not, rint, splat, sqrt, store, where, with_lane
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose, frame_pose, joint_turns, tree_poses, turned_chain_pose
from ulna.kernels.distance.body_records import Body, Core
from ulna.kernels.distance.box_sat import boxes_overlap, widest_gap
from ulna.kernels.distance.pairs import body_of, pair_distance, pair_overlap
from ulna.kernels.ik.damped_system import block_joints_at_bounds, solve_damped
from ulna.kernels.ik.levenberg_marquardt import ALLOWED, CHANGE, LAST_ERROR, N_STATE, advance
from ulna.kernels.ik.search_layout import POINTING
from ulna.kernels.ik.task_error import swing, task_error
from ulna.kernels.spatial.elementary import first_quadrant_angle, maximum, minimum, sincos
from ulna.kernels.spatial.se3 import (
    compose,
    constant_pose,
    load_pose,
    rotation_between,
    rotation_vector,
    slide_along_z,
    store_pose,
    turn_about_z,
)


def arithmetic(x, out):
    """Every operator between two numbers, and between a number and a plain float or integer on either side."""
    a, b = load(x, 0), load(x, 1)
    two = (a + b, a - b, a * b, a / b, -a, abs(a))
    mixed = (a + 2.5, a - 2.5, a * 2.5, a / 2.5, 2.5 + a, 2.5 - a, 2.5 * a, 2.5 / a, a * 3, 3 - a)
    for k in range(6):
        store(out, k, two[k])
    for k in range(10):
        store(out, 6 + k, mixed[k])


def comparisons(x, out):
    """1.0 where each comparison holds: two numbers, then a number and a plain float on either side."""
    a, b = load(x, 0), load(x, 1)
    masks = (a < b, a <= b, a > b, a >= b, a < 0.5, a <= 0.5, a > 0.5, a >= 0.5, 0.5 < a, 0.5 <= a, 0.5 > a, 0.5 >= a)  # noqa: SIM300
    for k in range(12):
        store(out, k, where(masks[k], 1.0, 0.0))


def logic(x, out):
    a, b = load(x, 0) > 0.0, load(x, 1) > 0.0
    masks = (a & b, a | b, logical_not(a), (a | logical_not(b)) & b, a ^ b)
    for k in range(5):
        store(out, k, where(masks[k], 1.0, 0.0))


def choices(x, out):
    """``where`` over two numbers, a number and a plain one, and two plain ones; ``splat``; ``rint``; ``sqrt``."""
    a, b = load(x, 0), load(x, 1)
    store(out, 0, where(a > b, a, b))
    store(out, 1, where(a > b, a, -7.0))
    store(out, 2, where(a > b, 3, b))
    store(out, 3, where(a > b, 1, 2))
    store(out, 4, splat(2.5, a))
    store(out, 5, rint(a))
    store(out, 6, sqrt(a))
    store(out, 7, minimum(a, b))
    store(out, 8, maximum(a, b))


def any_of(x, out):
    """1.0 in every lane if any lane is positive."""
    a = load(x, 0)
    store(out, 0, splat(1.0 if any_lane(a > 0.0) else 0.0, a))


def load_and_store(x, out):
    """Swap two rows by way of numbers: a load that gave a view would spoil it."""
    store(out, 0, load(x, 0))
    store(out, 1, load(x, 1))
    a, b = load(out, 0), load(out, 1)
    store(out, 0, b)
    store(out, 1, a)
    store(out, 2, 4.0)
    store(out, 3, 5)


def sine_and_cosine(x, out):
    s, c = sincos(load(x, 0))
    store(out, 0, s)
    store(out, 1, c)


def angle_in_first_quadrant(x, out):
    store(out, 0, first_quadrant_angle(load(x, 0), load(x, 1)))


def vector_of_rotation(x, out):
    v = rotation_vector((
        (load(x, 0), load(x, 1), load(x, 2)), (load(x, 3), load(x, 4), load(x, 5)), (load(x, 6), load(x, 7), load(x, 8)),
    ))  # fmt: skip
    for k in range(3):
        store(out, k, v[k])


def vector_between(x, out):
    v = rotation_between(load_pose(x, 0), load_pose(x, 1))
    for k in range(3):
        store(out, k, v[k])


def product(x, out):
    store_pose(out, 0, compose(load_pose(x, 0), load_pose(x, 1)))


def turn_and_slide(x, out):
    store_pose(out, 0, turn_about_z(load_pose(x, 0), load(x, 12)))
    store_pose(out, 1, slide_along_z(load_pose(x, 0), load(x, 12)))


def constant(table, x, out):
    store_pose(out, 0, constant_pose(table, 1, load(x, 0)))


def end_of_chain(chain, q, out):
    store_pose(out, 0, chain_pose(chain, q))


def end_of_chain_by_turns(chain, q, out):
    """The same; behind it two rows a joint."""
    joint_turns(chain, q, out[12:])
    store_pose(out, 0, turned_chain_pose(chain, out[12:]))


def frames_of_tree(joints, frames, q, out):
    """Twelve rows a joint of the table, then twelve a frame."""
    tree_poses(joints, q, out)
    for k in range(frames.shape[0]):
        store_pose(out, joints.shape[0] + k, frame_pose(frames, k, out, load(q, 0)))


def jacobian_of_chain(chain, expressed_in, n_dof, q, out):
    """Six rows an entry of q, and the twelve of the end's pose."""
    n = 6 * n_dof
    end = chain_jacobian(chain, q, expressed_in, out[:n], 6, 1)
    for k in range(12):
        store(out, n + k, end[k])


@kernel
def _six(x, k):
    """Six numbers from row k on."""
    return load(x, k), load(x, k + 1), load(x, k + 2), load(x, k + 3), load(x, k + 4), load(x, k + 5)


def damped_system(n_dof, x, out):
    """J, six rows an entry of q; the damping; e. The solution y is in the rows 21 to 26."""
    n = 6 * n_dof
    solve_damped(x, n_dof, load(x, n), _six(x, n + 1), out)


def one_advance(chain, posture, settings, x, out):
    """q, the target and the bounds give q after one step of a search, the q of its answer, the state, and scratch."""
    n = posture.shape[0]
    for j in range(n):
        store(out, j, load(x, j))
    q_rows, last_rows, state_rows = out[:n], out[n : 2 * n], out[2 * n : 2 * n + N_STATE]
    scratch = out[2 * n + N_STATE :]
    zero = splat(0.0, load(x, 0))
    for k in range(N_STATE):
        store(state_rows, k, zero)
    store(state_rows, LAST_ERROR, zero + np.inf)
    store(state_rows, ALLOWED, zero + 20.0)
    store(state_rows, CHANGE, zero + (np.inf if settings[0].with_posture else 0.0))
    rows = (q_rows, last_rows, x[n : n + 12], x[n + 12 :], state_rows)
    advance(chain, posture, settings[0], rows, (scratch[: 6 * n], scratch[6 * n :]))


def columns_that_are_free(n_dof, x, out):
    """J, e, q and the bounds give the columns of J that the bounds leave."""
    n = 6 * n_dof
    for k in range(n):
        store(out, k, load(x, k))
    block_joints_at_bounds(x[n + 6 + n_dof :], x[n + 6 : n + 6 + n_dof], _six(x, n), out[:n])


def error_of_task(settings, n_dof, x, out):
    """Pose, target, e and J give the error that a task counts and the rows of J, in the target's axes."""
    for k in range(6 * n_dof):
        store(out, 6 + k, load(x, 30 + k))
    is_pointing, slack = settings[0].task == POINTING, settings[0].slack
    e = task_error(is_pointing, slack, load_pose(x, 0), load_pose(x, 1), _six(x, 24), out[6 : 6 + 6 * n_dof])
    for k in range(6):
        store(out, k, e[k])


def swing_of_axes(x, out):
    v = swing(load_pose(x, 0), load_pose(x, 1))
    for k in range(3):
        store(out, k, v[k])


def two_boxes(x, out):
    """Pose and half extents of two boxes: whether they overlap, the widest gap, and its axis."""
    a, b = load_pose(x, 0), load_pose(x[15:], 0)
    h, g = (load(x, 12), load(x, 13), load(x, 14)), (load(x, 27), load(x, 28), load(x, 29))
    store(out, 0, where(boxes_overlap(a, h, b, g), 1.0, 0.0))
    gap, axis = widest_gap(a, h, b, g)
    store(out, 1, gap)
    store(out, 2, axis)


def two_bodies(kind_a, vertices_a, kind_b, vertices_b, scratch, x, out):
    """Pose, half extents and radius of two bodies: signed distance, witness points, normal; and whether they overlap."""
    core_a = Core(kind_a, (load(x, 12), load(x, 13), load(x, 14)), vertices_a)
    core_b = Core(kind_b, (load(x, 28), load(x, 29), load(x, 30)), vertices_b)
    a, b = Body(load_pose(x, 0), core_a, load(x, 15)), Body(load_pose(x[16:], 0), core_b, load(x, 31))
    distance, p, q, n = pair_distance(a, b, scratch)
    store(out, 0, distance)
    for k in range(3):
        store(out, 1 + k, p[k])
        store(out, 4 + k, q[k])
        store(out, 7 + k, n[k])
    store(out, 10, where(pair_overlap(a, b, splat(1.0, a.radius)), 1.0, 0.0))


def single_lanes(x, out):
    """The lanes of a number one by one: each is doubled where it stands."""
    a = load(x, 0)
    b = a
    for lane in range(lane_count(a)):
        b = with_lane(b, lane, 2.0 * lane_of(a, lane))
    store(out, 0, a)
    store(out, 1, b)


def row_of_bodies(bodies, vertices, x, out):
    """Row 1 of a table of bodies at a pose: kind, half extents and radius, and how many vertices."""
    pose, core, radius = body_of(bodies, vertices, 1, load_pose(x, 0))
    store(out, 0, splat(core.kind, pose[0]))
    for k in range(3):
        store(out, 1 + k, core.half[k])
    store(out, 4, radius)
    store(out, 5, splat(core.vertices.shape[0], pose[0]))
    store(out, 6, splat(core.vertices[0, 2], pose[0]))
