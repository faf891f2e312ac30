"""What the searches for a configuration share: the settings they read, the information they write, the status codes."""

SOLVED, NOT_FOUND, NOT_A_POSE, STATIONARY = 0, 1, 2, 3

# Entries of the settings.
POSITION_TOLERANCE, ROTATION_TOLERANCE, MAX_ITERATIONS, SEEDED, WITH_POSTURE = 0, 1, 2, 3, 4
N_SETTINGS = 5

# Columns of the information, a row a target. The errors are of the configuration returned [m and rad].
STATUS, POSITION_ERROR, ROTATION_ERROR, ITERATIONS = 0, 1, 2, 3
N_INFO = 4
