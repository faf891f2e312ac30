"""Numbers the commands, the tables and the results of a servo's tick. Plain numbers only."""

# What a tick is for. START sets the state and certifies its stop.
START, REST, VELOCITY, POSITION, HANDS = 0, 1, 2, 3, 4
# What a hand is sent to in a tick for HANDS: the rows of its chain in the table of all, begin and end; whether a twist or a pose
# is given; the frame of a twist; the weight of what it misses; and the twist, 6 numbers, or the pose, 12.
FIRST, END, GIVEN, FRAME, WEIGHT, GOAL = 0, 1, 2, 3, 4, 5
HAND_WIDTH = GOAL + 12
TWIST, POSE = 0, 1
# Rows of the limits, shape (N_LIMITS, n_dof): position, speed and acceleration; how far a joint may be from its command, and how
# far beside a motion all is certified besides, so that there is room to leave; the posture; and jerk.
LOWER, UPPER, SPEED, ACCELERATION, ASIDE, ROOM, POSTURE, JERK = 0, 1, 2, 3, 4, 5, 6, 7
N_LIMITS = 8
# The settings: the length of a tick [s]; how near an object may be [m]; lambda of the damping; the pull towards the posture
# [1/s], 0 for none; in how many ticks the limits of jerk let the greatest acceleration begin or end, 0 without such limits; and
# after what time the velocity desired is reached [s].
TICK, CLEARANCE, DAMPING, PULL, RAMP, LAG = 0, 1, 2, 3, 4, 5
N_SETTINGS = 6
# Rows of the state, shape (N_STATE, n_dof): position, velocity and acceleration now; the certified stop: its velocity and
# position where it begins, and where it ends; and, with a limit of jerk, its acceleration where it begins.
Q, QD, QDD, RATE, FROM, TO, ONSET = 0, 1, 2, 3, 4, 5, 6
N_STATE = 7
# Whole numbers of the state: how many ticks the stop takes, how many of these are over, whether it is certified now, how many
# pairs are in contact, which is only counted where it is not, and which share of a motion is tried first.
TICKS, DONE, CERTIFIED, TOUCHING, NEXT_SHARE = 0, 1, 2, 3, 4
N_COUNTERS = 5
# An object that may move by itself: its number, its greatest speed [m/s], how long ago it was said where it is [s], and 1 if it
# is in the BVH.
NUMBER, FASTEST, AGO, IN_TREE = 0, 1, 2, 3
MOVING_WIDTH = 4
# The report: what the tick was, the share of the velocity found that was certified, the entry of q and the pair that limit it
# (-1 for none), and how near that pair is where the arm would rest [m].
STATUS, SHARE, ENTRY, BODY, OTHER, DISTANCE = 0, 1, 2, 3, 4, 5
N_REPORT = 6
(
    FOLLOWING, LIMITED_BY_POSITION, LIMITED_BY_VELOCITY, LIMITED_BY_ACCELERATION, LIMITED_BY_JERK, LIMITED_BY_CLEARANCE,
    NEAR_SINGULARITY, BRAKING, AT_REST, NOT_CERTIFIED, IN_COLLISION, OFF_COMMAND, REFUSED,
) = range(13)  # fmt: skip
MOST_PAIRS = 24  # that the quadratic program has rows for: the nearest
MOST_TOUCHING = 64  # pairs in contact that may be led out of
