"""The state of a view, without a page: the robot, its hand, its joints, its clearance."""
