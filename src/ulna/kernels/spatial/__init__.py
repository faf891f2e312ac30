"""Vectors, rotations and poses. Used by all other kernels."""
