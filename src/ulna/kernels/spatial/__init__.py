"""Vectors, rotations and poses."""
