"""Poses, Jacobians and distances for JAX arrays, with gradients: ``import ulna.jax``; needs the extra ``jax``."""

from ulna.learning.callbacks import forward_kinematics, jacobian, signed_distance

__all__ = ["forward_kinematics", "jacobian", "signed_distance"]
