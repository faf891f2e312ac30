"""The methods of inverse kinematics, by name."""

TEXTBOOK = ("jacobian_transpose", "pseudo_inverse", "damped_least_squares")
METHODS = ("levenberg_marquardt", *TEXTBOOK)
