"""Sizes of the scratch arrays of inverse kinematics."""

N_SYSTEM = 27  # rows: the lower triangle of a 6x6 matrix, then a vector of six
N_TURNED = 42  # rows: six of the error, then the six columns of a 6x6 matrix
N_PER_JOINT = 16  # numbers: two columns of J (six each), whether a joint is in the active set, its goal, and its two bounds
