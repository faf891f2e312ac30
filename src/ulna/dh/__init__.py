"""Denavit-Hartenberg tables: from a table to a robot, from a robot to its table."""
