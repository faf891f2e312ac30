"""Reads SDF, the models of Gazebo."""
