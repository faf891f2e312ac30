"""Solves inverse kinematics numerically: Levenberg-Marquardt from many starts, and the reason for an unreached target."""
