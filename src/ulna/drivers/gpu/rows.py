"""Converts and picks rows on a GPU, so that they need not leave it. Used by ``robot.gpu_rows``."""

from ulna.engine.gpu import cuda


def converted(rows, out):
    """Write rows, shape (n, m), to out, of the same shape and of numbers of another size."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]


def taken(rows, order, out):
    """Write the rows (n, m) that an order (k,) names to out (k, m)."""
    i = cuda.grid(1)
    if i < out.shape[0]:
        for k in range(out.shape[1]):
            out[i, k] = rows[order[i], k]


def put(rows, order, out):
    """Write rows (k, m) to the rows of out (n, m) that an order (k,) names."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[order[i], k] = rows[i, k]


def column(rows, k, out):
    """Write column k of rows (n, m) to out (n,)."""
    i = cuda.grid(1)
    if i < out.shape[0]:
        out[i] = rows[i, k]
