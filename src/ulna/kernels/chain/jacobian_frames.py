"""Numbers the frames in which a Jacobian may be expressed."""

BASE, LINK, SPATIAL = 0, 1, 2
