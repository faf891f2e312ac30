"""One step of each inverse kinematics method."""
