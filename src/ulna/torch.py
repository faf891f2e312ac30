"""Poses, Jacobians and distances of PyTorch's tensors, with gradients: ``import ulna.torch``. It needs the extra ``torch``."""

from ulna.learning.tensors import forward_kinematics, jacobian, signed_distance

__all__ = ["forward_kinematics", "jacobian", "signed_distance"]
