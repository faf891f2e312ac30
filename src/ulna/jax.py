"""Poses, Jacobians and distances of JAX's arrays, with gradients: ``import ulna.jax``. It needs the extra ``jax``."""

from ulna.learning.callbacks import forward_kinematics, jacobian, signed_distance

__all__ = ["forward_kinematics", "jacobian", "signed_distance"]
