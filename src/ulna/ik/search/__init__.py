"""Numeric inverse kinematics: Levenberg-Marquardt from many starts, and why a target was not reached."""
