"""One step of each inverse kinematics method. Used by the drivers of ``ulna.ik``."""
