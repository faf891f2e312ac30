"""Extends a tree by a step: one edge, or several edges along constraints.

With constraints, a step consists of strides, each short enough for eight edges. First the stride itself is tried as one edge. If
it violates the constraints, it is divided into eight, and the eight configurations are projected onto the constraints at once
(CBiRRT: Berenson, Srinivasa, Ferguson and Kuffner, ICRA 2009). The tree then goes straight to the last of them, or half as far if
that edge violates the constraints, and so on. So a loose constraint needs one edge per stride, a tight one up to eight. All edges
of a stride lie close to one chord, so one collision certificate of the chord with a spread (``edge``) usually covers all.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import WIDTH
from ulna.kernels.planning.space import distance, write_step
from ulna.planning.entries.edge import check_edge, is_clear, record_refused
from ulna.planning.entries.keeping import project, satisfies_all
from ulna.planning.entries.search_records import BESIDE, REACHED, STOPPED
from ulna.planning.entries.tree import add_node, read_sample, sample_entry

MIN_PROGRESS = 0.25  # minimum progress, as a share of a stride


@kernel
def extend(context, trees, tree, near, step, radius, state):
    """Add the nodes of a step from a node of a tree.

    step: the node's configuration, and the target, which is overwritten by the last node's.

    Returns:
        The last node, or -1 if none was added; and how the step ended: STOPPED, BESIDE or REACHED (``search_records``).
    """
    return extend_by(context.keeping, context, trees, (tree, near), step, radius, state)


@kernel
def extend_by(keeping, context, trees, own, step, radius, state):
    """``extend``, compiled for the constraints of the context or None. own: the tree, and its node."""
    tree, near = own
    if keeping is not None:
        return extend_along(context, trees, own, step, radius, state)
    if not check_edge(context, step[0], step[1], trees.refused, state):
        return -1, STOPPED
    return add_node(trees, tree, state, step[1], near, radius), REACHED


@routine
def extend_along(context, trees, own, step, radius, state):
    """``extend`` along the constraints; the configuration of the node is overwritten by the last node's."""
    (tree, near), (at, new) = own, step
    curve, settings, space, node, end = context.keeping.curve, context.settings, context.space, near, BESIDE
    aim = curve[WIDTH + 1]
    for _ in range(settings.max_strides):
        left = distance(at, new, space)
        share = min(1.0, settings.stride / left)
        write_step(at, new, share, space, aim)
        n, end = write_curve(context, at, aim, state)
        for i in range(n):
            node = add_node(trees, tree, state, curve[i], node, radius)
        if n > 0:
            copy_point(curve[n - 1], at)
        if end == STOPPED:
            record_refused(at, curve[WIDTH], trees.refused, state)
        if end == STOPPED or share == 1.0:
            break
        end = BESIDE
        if gains_little(at, new, left, share, space) or state.checks >= state.max_checks:
            break
    copy_point(at, new)
    return (node if node != near else -1), end


@kernel
def gains_little(at, goal, before, share, space):
    """Whether a stride by a share of the distance made less than the minimum progress towards a goal."""
    return distance(at, goal, space) > before * (1.0 - MIN_PROGRESS * share)


@routine
def copy_point(q, out):
    """Copy a configuration."""
    for k in range(q.shape[0]):
        out[k] = q[k]


@routine
def write_curve(context, q_a, q_b, state):
    """Write the waypoints of a path along the constraints from q_a to q_b: their number, without q_a, and the end.

    All edges are free and satisfy the constraints. If the end is STOPPED, row WIDTH has the configuration that was not reached.
    """
    rows, curve, n, done = context.keeping.way_rows, context.keeping.curve, 0, 0
    state.checks += 1
    if satisfies_all(context.check.scene.joints, context.keeping, context.check.work, q_a, q_b, context.no_spread):
        free = is_clear(context, q_a, q_b, context.no_spread, context.settings.resolution)
        copy_point(q_b, curve[0 if free else WIDTH])
        return (1, REACHED) if free else (0, STOPPED)
    write_way(q_a, q_b, rows)
    project(context.check.scene.joints, context.keeping, q_a, context.no_spread, rows)
    end = REACHED
    for k in range(q_b.shape[0]):
        end = end if rows[k, WIDTH - 1] == q_b[k] else BESIDE
    size = WIDTH // 2 if end == REACHED else WIDTH
    while done < WIDTH and size > 0:
        size = min(size, WIDTH - done)
        for k in range(q_b.shape[0]):
            curve[WIDTH, k] = rows[k, done + size - 1]
        state.checks += 1
        before = curve[n - 1] if n > 0 else q_a
        if satisfies_all(
            context.check.scene.joints, context.keeping, context.check.work, before, curve[WIDTH], context.no_spread
        ):
            copy_point(curve[WIDTH], curve[n])
            n, done = n + 1, done + size
        else:
            size //= 2
    clear = clear_until(context, q_a, n, state)
    if clear < n:
        copy_point(curve[clear], curve[WIDTH])
    return clear, end if clear == n and done == WIDTH else STOPPED


@routine
def clear_until(context, q_a, n, state):
    """The number of free edges before the first contact, among n edges of a path from q_a."""
    curve, spread, done, size = context.keeping.curve, context.keeping.curve[WIDTH + 2], 0, n
    while done < n:
        size = min(size, n - done)
        before = curve[done - 1] if done > 0 else q_a
        write_spread(curve, done, size, before, spread)
        state.checks += 1
        if is_clear(context, before, curve[done + size - 1], spread, np.inf if size > 1 else context.settings.resolution):
            done += size
        elif size == 1:
            return done
        else:
            size //= 2
    return n


@routine
def write_spread(curve, first, n, before, spread):
    """Write the largest distance of the corners of n edges from their chord in each entry of q.

    No point of these edges is farther from the chord. before: the start of the edges, before the corner ``first``.
    """
    for k in range(before.shape[0]):
        spread[k], chord = 0.0, curve[first + n - 1, k] - before[k]
        for i in range(n - 1):
            spread[k] = max(spread[k], abs(curve[first + i, k] - before[k] - (i + 1) / n * chord))
        spread[k] *= 1.0 + 1e-9  # for rounding


@routine
def write_way(at, new, rows):
    """Write eight configurations that divide a step, the last of them its end."""
    for lane in range(WIDTH):
        share = (lane + 1) / WIDTH
        for k in range(new.shape[0]):
            rows[k, lane] = at[k] + share * (new[k] - at[k]) if lane < WIDTH - 1 else new[k]


@kernel
def read_target(keeping, context, samples, state, q):
    """Write the configuration of the next sample to q, projected onto the constraints if there are any."""
    if keeping is None:
        read_sample(samples, context.space, state, q)
    else:
        read_sample_along(context, samples, state, q)


@routine
def read_sample_along(context, samples, state, q):
    """Write the configuration of the next sample to q, projected onto the constraints, eight samples at once."""
    rows, block, space = context.keeping.sample_rows, context.keeping.sampled, context.space
    if block[0] != state.sample // WIDTH:
        block[0] = state.sample // WIDTH
        for lane in range(WIDTH):
            row = min(block[0] * WIDTH + lane - state.first_sample, samples.shape[0] - 1)
            for k in range(q.shape[0]):
                rows[k, lane] = sample_entry(samples, space, row, k)
        for k in range(q.shape[0]):
            q[k] = rows[k, 0]
        project(context.check.scene.joints, context.keeping, q, context.no_spread, rows)
    for k in range(q.shape[0]):
        q[k] = rows[k, state.sample % WIDTH]
    state.sample += 1
