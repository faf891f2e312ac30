"""Numbers the codes of IK searches, and sizes their scratch arrays."""

# NOT_A_POSE: the target is no rigid motion, or the seed is out of range; the caller finds out which.
SOLVED, NOT_FOUND, NOT_A_POSE = 0, 1, 2
# The components of the pose error that a task requires, in the target's axes.
WHOLE_POSE, WITH_SLACK, POINTING = 0, 1, 2
# Early end of a search for one target (``ik.entries.multi_start``).
ANY, NEAREST = 1, 2
# Scratch arrays.
N_SYSTEM = 27  # rows: the lower triangle of a 6x6 matrix, then a vector of six
N_TURNED = 42  # rows: six of the error, then the six columns of a 6x6 matrix
N_PER_JOINT = 16  # numbers: two columns of J (six each), whether a joint is in the active set, its goal, and its two bounds
