"""What the raster kernels write. Plain numbers only. Used by them and ``viewer.film``."""

NOTHING = -1  # the number of no triangle
