"""Expands xacro files in a child process."""
