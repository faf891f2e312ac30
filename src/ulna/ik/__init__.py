"""Inverse kinematics: the problem, the search, and a result that says how it went."""
