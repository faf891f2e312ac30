"""Forward kinematics and Jacobians of a chain or a tree. Used by ``drivers``, ``kernels.collision`` and ``kernels.ik``."""
