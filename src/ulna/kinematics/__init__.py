"""Computes kinematics with NumPy arrays. Arguments are validated here, once; the kernels do not validate them again."""
