"""What the raster kernels write. Plain numbers only."""

NOTHING = -1  # the number of no triangle
