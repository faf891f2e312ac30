"""How a formula becomes machine code. The only package that knows Numba."""
