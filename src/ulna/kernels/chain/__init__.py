"""Forward kinematics and Jacobians of a chain or a tree."""
