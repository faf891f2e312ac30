"""Formulas of planning: nearest nodes, steps in the space of configurations, the domain of a node."""
