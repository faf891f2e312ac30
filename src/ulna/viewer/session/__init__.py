"""The state of a view, without its page: the robot, its hand, its joints, its clearance."""
