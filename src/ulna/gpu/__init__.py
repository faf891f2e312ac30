"""Computes a robot's batches on a GPU by the kernels of the CPU, one problem per thread.

This package is a layer below ``robot``: of a robot it uses only the members in ``search.OnHost``. A driver is a plain function
that numba-cuda compiles; its kernels compute in float64. Scratch is in local memory, whose size the compiler must know. So a
driver with scratch is made for the size of a robot, and cached.
"""
