"""The demo in RViz. Only this package orders quaternions x, y, z, w."""
