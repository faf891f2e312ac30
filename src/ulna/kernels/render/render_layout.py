"""Numbers that the raster kernels write."""

NOTHING = -1  # the number of no triangle
