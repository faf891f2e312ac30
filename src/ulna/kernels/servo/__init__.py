"""Formulas of a servo: the desired motion, the quadratic program and the braking trajectory."""
