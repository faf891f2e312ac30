"""Converts and combines results on a GPU, so that they need not leave it. Used by ``robot.gpu_robot`` and ``robot.gpu_scene``."""

from ulna.engine.gpu import cuda


def converted(rows, out):
    """Write rows, shape (n, m), to out, of the same shape and of numbers of another size."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]


def either(more, out):
    """Write to the bools out, shape (n,), whether they or more are true."""
    i = cuda.grid(1)
    if i < out.shape[0]:
        out[i] = out[i] or more[i]


def least(more, out):
    """Write to out, shape (n,), the smaller of it and more."""
    i = cuda.grid(1)
    if i < out.shape[0]:
        out[i] = min(out[i], more[i])
