"""What ``ulna.torch`` and ``ulna.jax`` have in common: functions of q, and their gradients. It imports neither library."""
