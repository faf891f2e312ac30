"""Defines ``NOTHING``: the triangle number that the raster kernels write for a sample without a triangle."""

NOTHING = -1  # the number of no triangle
