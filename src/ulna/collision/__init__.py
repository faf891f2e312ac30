"""Collision: the robot's shapes against a world of named ones."""
