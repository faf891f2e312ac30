"""Dynamics: the torques that a motion needs, and the motion that torques cause."""
