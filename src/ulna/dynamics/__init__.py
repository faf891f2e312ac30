"""Dynamics: the torques of a robot's motions, and the motions of its torques."""
