"""Formulas of planning: nearest nodes, steps in configuration space, constraints, time parameterization."""
