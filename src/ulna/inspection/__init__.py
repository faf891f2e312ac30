"""Checks of robot descriptions, loadable or not, and comparisons of two descriptions of one robot."""
