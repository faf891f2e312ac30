"""Formulas of vectors, rotations and poses."""
