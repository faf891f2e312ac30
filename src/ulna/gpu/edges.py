"""Certifies straight edges on a GPU, one edge per thread, by the bounds of the CPU (``collision.entries.continuous``).

A thread examines one interval of its edge at a time, from the start on. A clear interval is done, any other is halved. So the
free part of an edge is known as soon as its verdict.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ulna.collision.entries.carried import carried_by
from ulna.engine.decorators import kernel
from ulna.gpu import device, staged
from ulna.gpu.collision import as_it_is, of_boxes
from ulna.gpu.scenes import BOXES, DeviceScene
from ulna.kernels.collision.ball_motion import INSTANT, ROUNDING, fastest_ball, place_balls, world_rounding, write_motion
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.collision_layout import STEP_LENGTH, STEP_WIDTH
from ulna.kernels.collision.interval import self_outcome, world_outcome
from ulna.kernels.collision.scene import Carried, Intervals
from ulna.kernels.spatial.elementary import all_in_range

_THREADS, _DEPTH = 1 << 16, 128  # threads; levels of halved intervals, more than float64 can distinguish between 0 and 1


class EdgeTables(NamedTuple):
    """Tables for edges in a scene, on the device: the fields of ``Carried`` that belong to the scene, and numbers."""

    balls: Any
    order: Any
    first: Any
    groups: Any
    runs: Any
    others: Any
    lengths: Any
    object_rounding: float


def edge_tables(scene: DeviceScene, known: EdgeTables | None = None) -> EdgeTables:
    """The tables of a scene; known: those of the same robot with another world."""
    if known is None:
        carried = carried_by(scene.on_host)
        balls, order, first, groups, runs, others, lengths = map(device.on_device, (*carried[:6], carried.steps[:, STEP_LENGTH]))
        known = EdgeTables(balls, order, first, groups, runs, others, lengths, 0.0)
    of_clouds = max((4.0 * ROUNDING * placed.farthest for placed in scene.clouds), default=0.0)
    return known._replace(object_rounding=max(float(world_rounding(scene.on_host)), of_clouds))


def near_for(scene: DeviceScene, n: int, stream: Any) -> Any:
    """Memory for the objects near a ball, one row per thread, for n edges on a stream."""
    return device.empty((max(1, min(n, _THREADS)), max(1, scene.on_host.end - scene.on_host.first)), np.int64, stream)


@cache
def edges_of(n_dof: int, n_joints: int, n_bodies: int, kind: int, is_indexed: bool, n_balls: int) -> Any:
    """The driver for scenes of these sizes with ``n_balls`` balls: the last free configuration of each edge, rows of n_dof.

    The rows are q_a. tables: (scene, ``EdgeTables`` as a tuple, near, (resolution, margin), q_b). marks: the flag, whether the
    edge is in collision, and its free fraction.
    """
    of_joints, of_twists, of_balls, of_centers, columns = 12 * n_joints, 6 * n_joints, 7 * n_balls, 3 * n_bodies, n_joints + 1
    as_scene, of_stack = of_boxes if kind == BOXES else as_it_is, STACK if is_indexed else 1

    @kernel
    def edges(tables, q_a, place, _own, q_out, marks):
        scene, q_b = as_scene(tables[0]), tables[4][place[0]]
        if not (all_in_range(q_a) and all_in_range(q_b)):
            return True
        balls, order, first, groups, runs, others, lengths, object_rounding = tables[1]
        steps = staged.cuda.local.array((n_joints, STEP_WIDTH), np.float64)
        speeds = staged.cuda.local.array((n_balls, columns), np.float64)
        bends = staged.cuda.local.array((n_balls, columns), np.float64)
        slacks, joint_rows = staged.cuda.local.array(n_balls, np.float64), staged.cuda.local.array(of_joints, np.float64)
        twist_rows, ball_rows = staged.cuda.local.array(of_twists, np.float64), staged.cuda.local.array(of_balls, np.float64)
        center_rows, placed = staged.cuda.local.array(of_centers, np.float64), staged.cuda.local.array(n_balls, np.int64)
        q, spread = staged.cuda.local.array(n_dof, np.float64), staged.cuda.local.array(n_dof, np.float64)
        ends, stack = staged.cuda.local.array(_DEPTH, np.float64), staged.cuda.local.array(of_stack, np.int64)
        carried = Carried(
            balls, order, first, groups, runs, others, steps, speeds, bends, slacks, joint_rows, twist_rows, ball_rows,
            center_rows, placed, tables[2][place[2]],
        )  # fmt: skip
        for i in range(n_joints):
            steps[i, STEP_LENGTH] = lengths[i]
        for j in range(n_dof):
            spread[j] = 0.0
        write_motion(scene.joints, q_a, q_b, spread, carried)
        hits, low = free_part(scene, carried, object_rounding, (q_a, q_b, q), tables[3], ends, stack)
        marks[1][place[0]], marks[2][place[0]] = hits, low
        write_place(q_a, q_b, low, q_out)
        return False

    return staged.over_rows(edges, n_dof, n_dof)


@kernel
def free_part(scene, carried, object_rounding, edge, lengths, ends, stack):
    """Whether an edge is in collision, or closer than the resolution, and the certified free fraction before that.

    edge: q_a, q_b, and memory for a configuration. lengths: the resolution, and the margin from objects of the world [m].
    """
    fastest, low, high, top, hits = fastest_ball(scene.joints, carried), 0.0, 1.0, 0, False
    resolution, margin = lengths
    while low < high:
        t, half = 0.5 * (low + high), 0.5 * (high - low) + INSTANT
        write_place(edge[0], edge[1], t, edge[2])
        place_balls(scene.joints, edge[2], half, False, carried)
        intervals = Intervals(half, False, True, margin, None, object_rounding)
        touches, clear = world_outcome(scene, carried, intervals, stack, t)
        if not touches:
            touches, clear = self_outcome(scene, carried, intervals, clear, t)
        if not touches and clear > 0.0:
            low = high
            if top > 0:
                top -= 1
                high = ends[top]
        elif (high - low) * fastest <= resolution:
            hits, high = True, low
        elif touches:  # the rest is irrelevant
            hits, high, top = True, t, 0
        else:
            ends[top], high = high, t
            top += 1
    return hits, low


@kernel
def write_place(q_a, q_b, t, q):
    """Write the configuration at a fraction of an edge."""
    for j in range(q.shape[0]):
        q[j] = t * (q_b[j] - q_a[j]) + q_a[j]
