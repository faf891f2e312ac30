"""Functions of q and their gradients, shared by ``ulna.torch`` and ``ulna.jax``. It imports neither library."""
