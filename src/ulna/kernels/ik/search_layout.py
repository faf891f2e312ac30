"""What the searches for a configuration share: the settings they read, the information they write, the status codes."""

# NOT_A_POSE: the target is no rigid motion, or the seed out of range: the caller looks which.
SOLVED, NOT_FOUND, NOT_A_POSE, STATIONARY = 0, 1, 2, 3
# What a task asks of the six components of the pose error, in the target's axes.
WHOLE_POSE, WITH_SLACK, POINTING = 0, 1, 2
# Entries of the settings. STEPS: the most from one start. CALM: damping in proportion to the error's size, which lets a search
# come to rest where the target cannot be met. SLACK: six entries, by how much each component may be off at no cost [m, rad],
# read unless the task is the WHOLE_POSE.
# FAR: the square of a distance [m^2] beyond which a larger one damps no more; 0 where every distance damps.
POSITION_TOLERANCE, ROTATION_TOLERANCE, STEPS, CALM, FIRST_WINS, WITH_POSTURE, TASK, FAR, SLACK = 0, 1, 2, 3, 4, 5, 6, 7, 8
N_SETTINGS = SLACK + 6
# Columns of the information, a row an answer. ITERATIONS: steps from the START that is answered; DAMPING: the last step's.
# The errors are those of the configuration answered [m and rad]; from RESIDUAL on, their components in the target's axes;
# MISSED: the squares of what the task asks for and is not met [m^2 + rad^2].
STATUS, POSITION_ERROR, ROTATION_ERROR, ITERATIONS, START, DAMPING, MISSED, RESIDUAL = 0, 1, 2, 3, 4, 5, 6, 7
N_INFO = RESIDUAL + 6
