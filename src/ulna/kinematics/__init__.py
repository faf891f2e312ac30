"""Kinematics: NumPy arrays in and out. Arguments are checked here, once; the kernels below check nothing."""
