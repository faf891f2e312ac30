"""The mathematics: formulas over a generic number, compiled by Numba.

A kernel takes numbers, tuples and caller-owned arrays. It allocates nothing, raises nothing and validates nothing.
The number is a float64, eight float64 in one vector register (``lanes``), or, without the compiler, a NumPy array.

Words used in every kernel
--------------------------
number  a float64, an ``f64x8``, or an array of shape (width,)
rows    an array whose ``rows[i]`` is one number: shape (n,) for float64, (n, 8) for ``f64x8``, (n, width) for NumPy
pose    twelve numbers, the upper 3x4 part of a homogeneous matrix row by row
"""
