"""Follows paths of poses: a joint path, or the reason why there is none."""
