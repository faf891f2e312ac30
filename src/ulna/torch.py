"""Poses, Jacobians and distances for PyTorch tensors, with gradients: ``import ulna.torch``; needs the extra ``torch``."""

from ulna.learning.tensors import forward_kinematics, jacobian, signed_distance

__all__ = ["forward_kinematics", "jacobian", "signed_distance"]
