"""Numbers the settings, the state and the codes of planning, and names the arrays of a search."""

from typing import NamedTuple

from numpy.typing import NDArray

# The search.
RRT_CONNECT, AORRTC = 0, 1  # the algorithms
# Settings of a search.
RANGE = 0  # the longest edge of a tree, in the metric of the space
RESOLUTION = 1  # of a certificate [m]
MARGIN = 2  # how near an object of the world may be [m]
SAMPLED = 3  # 0: edges are certified; else the spacing of the samples of an edge, in the metric
DOMAIN, LEAST_DOMAIN, ADAPTATION = 4, 5, 6  # the radius of a node that could not be extended, its least value, its rate of change
ROOM = 7  # how many steps one iteration may take, and two more
BOUND = 8  # of the cost of a path that is to be cheaper
NODES_A_STEP = 9  # how many nodes a step towards a configuration may add: with constraints several
STRIDE, STRIDES = 10, 11  # along constraints a step is made of strides: how long one may be, and how many there may be
N_SETTINGS = 12
# Rows of the space, shape (N_SPACE, n_dof): where samples are taken from, the weight of each entry of q in the metric, and the
# whole turn of an entry that may turn for ever, else 0.
LOW, HIGH, WEIGHT, PERIOD = 0, 1, 2, 3
N_SPACE = 4
# State of a search.
STARTS, GOALS = 0, 1  # the numbers of nodes of the two trees
SAMPLE, CHECKS, UNTIL, DIRECT, ACTIVE, JOINED_START, JOINED_GOAL, ITERATIONS, FIRST_SAMPLE = 2, 3, 4, 5, 6, 7, 8, 9, 10
GOAL_ROOTS = 11  # how many of the nodes of the second tree are goals: the first ones
PASSED, MOST = 12, 13  # how many samples were skipped; how many edges the whole search may check
JOINED = 14  # 1 once the trees are joined
GOAL_REACHED = 15  # the root of the second tree that the path leads to; -1 before there is one
IN_A_ROW = 16  # how many samples were skipped since the last that was not
FAILED = 17  # and 18: of each tree, how many edges towards samples were not free since the last that was
ALGORITHM = 19
REFUSED = 20  # how many edges were not free
N_STATE = 21
MOST_REFUSED = 32  # of these, so many are kept
PASSED_A_CHECK = 64  # samples that were skipped count as one checked edge: they take about as long
# After so many skipped samples the next is tried wherever it is: where a tree is hemmed in and joints are many, hardly any sample
# lies within the domains of its few nodes.
MOST_IN_A_ROW = 16
# So many failed edges halve the steps of a tree towards samples, so often; a free edge makes them long again.
FAILED_A_HALF, MOST_HALVES = 128, 3
# How a call ends: solved; paused at its number of checks; no room for more nodes; no sample left; an edge that is not free; no
# room for the path.
SOLVED, PAUSED, FULL, NO_SAMPLE, NOT_FREE, NO_ROOM = 0, 1, 2, 3, 4, 5
# State of shortening, besides CHECKS and UNTIL: how many points, the pass, where in it, and for how many points there is room.
# The last pass confirms every edge.
POINTS, PASS, AT, OTHER, ROWS = 0, 1, 2, 5, 6
SHORTEN, CONFIRM = 0, 5
SPARE_POINTS = 128  # besides twice the points of a path: room to shorten it
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
# How a step towards a configuration ends: not free; at another configuration, which keeps the constraints; there.
STOPPED, BESIDE, REACHED = 0, 1, 2


# An entry takes the arrays one by one: ``entry(*trees)``.
class Trees(NamedTuple):
    """The two trees of a search: tree 0 from the start, tree 1 from the goals. Room for ``capacity`` nodes, a multiple of 8."""

    rows: NDArray
    """The nodes (``space``), shape (2, capacity / 8 * n_dof, 8)."""
    parents: NDArray
    """Of each node, -1 for a root, shape (2, capacity)."""
    radii: NDArray
    """Of each node's domain, shape (2, capacity)."""
    costs: NDArray
    """The cost to reach each node, infinite in unused places, shape (2, capacity / 8, 8); for RRT_CONNECT (2, 0, 8)."""
    refused: NDArray
    """The last edges that were not free, in a ring, shape (MOST_REFUSED, 2, n_dof)."""


class Path(NamedTuple):
    """A path that was found, with room to shorten it."""

    waypoints: NDArray
    """Shape (capacity, n_dof)."""
    known: NDArray
    """1 where the edge from a waypoint was found free as it is, else 0, shape (capacity,)."""
    spreads: NDArray
    """How far beside each edge all is to be free too, shape (n - 1, n_dof), or (0, n_dof)."""
