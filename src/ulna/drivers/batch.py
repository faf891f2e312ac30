"""Gathers a batch into rows of lanes and scatters the results, eight problems at a time. Used by all other drivers.

A batch has one problem after the other in memory; rows of lanes have the same number of eight problems together.

The last block of a batch is filled up with its last problem, computed and written more than once: every problem takes the
same path whatever the batch's length and its own place, so its result is the same bit for bit.
"""

from ulna.engine.decorators import kernel
from ulna.engine.width import WIDTH


@kernel
def gather(batch, start, rows):
    """Rows of the eight problems batch[start], batch[start + 1], ..."""
    for lane in range(WIDTH):
        i = min(start + lane, batch.shape[0] - 1)
        for k in range(batch.shape[1]):
            rows[k, lane] = batch[i, k]


@kernel
def write_matrix(pose, out):
    """Write a pose of plain numbers as a homogeneous 4x4 matrix."""
    for k in range(12):
        out[k // 4, k % 4] = pose[k]
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0


@kernel
def scatter_matrix(pose_rows, i, lane, out):
    """Write one lane of pose i of rows as a homogeneous 4x4 matrix."""
    for k in range(12):
        out[k // 4, k % 4] = pose_rows[12 * i + k, lane]
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0


@kernel
def share_no_memory(a, b):
    """True if two arrays, each in one piece, share no memory: what is written to one does not change the other."""
    start_a, start_b = a.ctypes.data, b.ctypes.data
    return start_a + a.nbytes <= start_b or start_b + b.nbytes <= start_a
