"""Two convex shapes: overlap, distance, penetration depth. Used by ``kernels.collision``."""
