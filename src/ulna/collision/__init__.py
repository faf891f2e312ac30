"""Collision: the robot's shapes against a world of named objects, and against each other."""
