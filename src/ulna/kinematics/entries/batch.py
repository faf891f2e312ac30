"""Gathers a batch into rows of lanes and scatters the results, eight problems at a time.

In a batch, the numbers of one problem are contiguous. In rows of lanes, the same number of eight problems is contiguous.

The last block of a batch is padded with its last problem, which is computed more than once. So every problem takes the same path
for any length of the batch and any place in it, and has the same bits.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import WIDTH, load, load_columns, splat, store, store_columns
from ulna.kernels.spatial.se3 import lane_pose, store_pose


@kernel
def gather(batch, start, rows):
    """Fill rows with the eight problems batch[start], batch[start + 1], ...

    Eight columns at a time are loaded and transposed. If this would read past the end of the batch, as in its last block, they
    are copied number by number.
    """
    n, columns = batch.shape
    for k in range(0, columns, WIDTH):
        if start + WIDTH <= n and (start + WIDTH - 1) * columns + k + WIDTH <= batch.size:
            numbers = load_columns(batch, start, k)
            for j in range(WIDTH):
                if k + j < columns:
                    store(rows, k + j, numbers[j])
        else:
            gather_one_by_one(batch, start, k, rows)


@routine
def gather_one_by_one(batch, start, k, rows):
    """Copy at most eight columns, from k on, number by number. Lanes past the end get the last problem.

    It is a separate function, since its counters would slow down the loop over full blocks.
    """
    for j in range(k, min(k + WIDTH, batch.shape[1])):
        for lane in range(WIDTH):
            rows[j, lane] = batch[min(start + lane, batch.shape[0] - 1), j]


@kernel
def gather_poses(matrices, start, pose_rows):
    """Fill rows with the upper three rows of eight matrices (n, 4, 4), from ``start`` on.

    Lanes past the end get the last matrix.
    """
    for k in range(0, 16, WIDTH):
        numbers = load_columns(matrices, start, k)
        for j in range(WIDTH):
            if k + j < 12:
                store(pose_rows, k + j, numbers[j])


@kernel
def scatter_rows(rows, n, out, start):
    """Write n rows to out[start], out[start + 1], ..., which have n numbers each.

    Eight rows at a time are transposed and written; the last eight may repeat some rows. Fewer than eight rows, or an incomplete
    block, are written number by number.
    """
    if n < WIDTH or start + WIDTH > out.shape[0]:
        scatter_one_by_one(rows, n, out, start)
        return
    for first in range(0, n, WIDTH):
        k = min(first, n - WIDTH)
        numbers = (
            load(rows, k), load(rows, k + 1), load(rows, k + 2), load(rows, k + 3),
            load(rows, k + 4), load(rows, k + 5), load(rows, k + 6), load(rows, k + 7),
        )  # fmt: skip
        store_columns(out, start, k, numbers)


@routine
def scatter_one_by_one(rows, n, out, start):
    """Write n rows number by number, up to the end of ``out``."""
    flat = out.reshape(-1)
    for lane in range(min(WIDTH, out.shape[0] - start)):
        for k in range(n):
            flat[(start + lane) * n + k] = rows[k, lane]


@kernel
def scatter_matrices(pose, pose_rows, out, start):
    """Write a pose in lanes to out[start], out[start + 1], ... as 4x4 matrices, half a matrix at a time.

    An incomplete block goes through pose_rows.
    """
    if start + WIDTH <= out.shape[0]:
        zero, one = splat(0.0, pose[0]), splat(1.0, pose[0])
        upper = pose[0], pose[1], pose[2], pose[3], pose[4], pose[5], pose[6], pose[7]
        lower = pose[8], pose[9], pose[10], pose[11], zero, zero, zero, one
        store_columns(out, start, 0, upper)
        store_columns(out, start, WIDTH, lower)
    else:
        store_pose(pose_rows, 0, pose)
        for lane in range(out.shape[0] - start):
            scatter_matrix(pose_rows, 0, lane, out[start + lane])


@kernel
def write_matrix(pose, out):
    """Write a pose of plain numbers as a homogeneous 4x4 matrix."""
    for k in range(12):
        out[k // 4, k % 4] = pose[k]
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0


@kernel
def scatter_matrix(pose_rows, i, lane, out):
    """Write one lane of pose i of rows as a homogeneous 4x4 matrix."""
    write_matrix(lane_pose(pose_rows, i, lane), out)


@kernel
def share_no_memory(a, b):
    """True if two contiguous arrays share no memory, so that writes to one do not change the other."""
    start_a, start_b = a.ctypes.data, b.ctypes.data
    return start_a + a.nbytes <= start_b or start_b + b.nbytes <= start_a
