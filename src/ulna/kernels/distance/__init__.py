"""Two convex shapes: overlap, distance, penetration depth."""
