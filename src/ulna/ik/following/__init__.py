"""Follows a path of poses by joint positions that never jump to another branch."""
