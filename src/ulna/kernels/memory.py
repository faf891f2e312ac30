"""Where arrays lie."""

from ulna.kernels.compile import kernel


@kernel
def apart(a, b):
    """True if two arrays, each in one piece, share no memory: what is written to one does not change the other."""
    start_a, start_b = a.ctypes.data, b.ctypes.data
    return start_a + a.nbytes <= start_b or start_b + b.nbytes <= start_a
