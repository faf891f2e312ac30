"""Converts numbers on a GPU, so that they need not leave it. Used by ``robot.gpu_robot``."""

from ulna.engine.gpu import cuda


def converted(rows, out):
    """Write rows, shape (n, m), to out, of the same shape and of numbers of another size."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]
