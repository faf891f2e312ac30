"""Numbers the settings, the results and the status codes of IK searches, and sizes their scratch arrays."""

# NOT_A_POSE: the target is no rigid motion, or the seed out of range: the caller finds out which.
SOLVED, NOT_FOUND, NOT_A_POSE = 0, 1, 2
# What a task requires of the six components of the pose error, in the target's axes.
WHOLE_POSE, WITH_SLACK, POINTING = 0, 1, 2
# Entries of the settings. STEPS: the most from one start. CALM: damping in proportion to the error's size, with which a search
# converges where the target is out of reach. SLACK: six entries, by how much each component may be off at no cost [m, rad],
# read unless the task is the WHOLE_POSE.
# FIRST_WINS: one of two ways in which a search for one target ends early (``drivers.multi_start``). SEEDED_STEPS: those of the
# first start; 0: STEPS.
# FAR: the square of a distance [m^2] beyond which a larger one damps no more; 0 where every distance damps.
POSITION_TOLERANCE, ROTATION_TOLERANCE, STEPS, CALM, FIRST_WINS, WITH_POSTURE, TASK, FAR, SEEDED_STEPS, SLACK = range(10)
ANY, NEAREST = 1, 2  # of FIRST_WINS
N_SETTINGS = SLACK + 6
# Columns of the information, a row a result. ITERATIONS: steps from the START of the result; DAMPING: the last step's.
# The errors are those of the configuration returned [m and rad]; from RESIDUAL on, their components in the target's axes;
# MISSED: the squared residual of the task [m^2 + rad^2].
STATUS, POSITION_ERROR, ROTATION_ERROR, ITERATIONS, START, DAMPING, MISSED, RESIDUAL = 0, 1, 2, 3, 4, 5, 6, 7
N_INFO = RESIDUAL + 6
# Scratch arrays.
N_SYSTEM = 27  # rows: the lower triangle of a 6x6 matrix, then a vector of six
N_TURNED = 42  # rows: six of the error, then the six columns of a 6x6 matrix
N_PER_JOINT = 16  # numbers: two columns of J (six each), whether a joint is in the active set, its goal, and its two bounds
