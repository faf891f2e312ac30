"""Numbers the frames in which a Jacobian may be expressed. Used by the Jacobian's kernels and by ``kinematics.jacobian``."""

BASE, LINK, SPATIAL = 0, 1, 2
