"""Numbers the rows of the space of a plan, and the columns of its constraints."""

# Rows of the space, shape (N_SPACE, n_dof): where samples are taken from, the weight of each entry of q in the metric, and the
# whole turn of an entry that may turn for ever, else 0.
LOW, HIGH, WEIGHT, PERIOD = 0, 1, 2, 3
N_SPACE = 4
# A constraint is so many rows of a table: its frame on the robot, in the columns of a table of frames (``kernels.layout``), with
# its tolerances; the frame that it is compared with, of the base or of the robot, and in the column SHARED the last joint that
# carries both, or BASE; the task of its projection, and from SLACK on how far each component may be off (``task_error``).
KEEP_ROWS, REFERENCE, PROJECTION = 3, 1, 2
TASK, SLACK = 6, 9
SHARED = 14
# Columns of the first row: by how much its origin may be off along each axis of the other frame, infinite if it is free [m];
# which axes are compared, or that z points TOWARDS the other's origin; the greatest length of their difference; how far its
# origin is from the joint's [m].
AWAY, AXES, CHORD, LEVER = 14, 17, 18, 19
KEEP_WIDTH = 20
NO_AXIS, Z_AXIS, ALL_AXES, TOWARDS = 0, 1, 2, 3
LEAST_LENGTH = 1e-30  # [m]: by which is divided
