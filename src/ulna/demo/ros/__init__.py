"""The demo in RViz. Only here quaternions have the order x, y, z, w."""
