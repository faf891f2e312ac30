"""A robot's batches on a GPU: the kernels of the CPU, one problem a thread.

It knows of a robot only what ``search.OnHost`` names, so it is below ``robot``. A driver is a plain function that numba-cuda
compiles; the number of its kernels is a float64. Scratch is in local memory, whose size the compiler must know: a driver that
needs some is made for the size of a robot, and kept.
"""
