"""Pictures and videos of any robot, without a display."""
