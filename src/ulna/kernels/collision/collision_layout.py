"""Numbers the columns and status codes of the collision kernels. Plain numbers only."""

# Overlap of one configuration.
FREE, OVERLAPS, OUT_OF_RANGE = 0, 1, 2
# Columns of a contact: the signed distance [m], the two witness points [m] and the normal from the first body to the second.
DISTANCE, WITNESS_A, WITNESS_B, NORMAL = 0, 1, 4, 7
CONTACT_WIDTH = 10
# Columns of a pair: the body of the robot; the other body, or the solid of the world, numbered from the last body on; the number
# of the solid's object, or -1 for a body.
PAIR_BODY, PAIR_OTHER, PAIR_OBJECT = 0, 1, 2
PAIR_WIDTH = 3
# A bounding plane of a body: its unit normal, and the body's maximum offset along it [m]; PLANES are kept for each body.
PLANE_NORMAL, PLANE_OFFSET = 0, 3
PLANE_WIDTH, PLANES = 4, 48
# Outcomes of an edge between two configurations.
EDGE_FREE, EDGE_CONTACT, EDGE_OUT_OF_RANGE = 0, 1, 2
# A ball that holds the bodies of one joint: the joint, the center in its frame [m], the radius [m], and the maximum distance of
# its points from the joint's origin [m].
BALL_JOINT, BALL_CENTER, BALL_RADIUS, BALL_LENGTH = 0, 1, 4, 5
BALL_WIDTH = 6
# A joint along an edge: its rate [rad or m]; the sum of the rotations of this joint and of those that carry it [rad]; its maximum
# slide [m]; its maximum deviation from the edge, with rounding [rad or m]; the factor from its rate to the acceleration of the
# points that it moves [rad]; 1 if it is prismatic, else 0; its frame's distance from its parent's [m], the same for all edges.
RATE, TURN, SLIDE, ASIDE, SWING, SLIDES, STEP_LENGTH = 0, 1, 2, 3, 4, 5, 6
STEP_WIDTH = 7
# The pairs of two balls, the larger one first: the balls, the joint that carries both, the first run and the one after the last.
GROUP_A, GROUP_B, GROUP_SHARED, GROUP_FIRST, GROUP_END = 0, 1, 2, 3, 4
GROUP_WIDTH = 5
# A run, the pairs of one body of the first ball: the body, the first pair and the one after the last.
RUN_BODY, RUN_FIRST, RUN_END = 0, 1, 2
RUN_WIDTH = 3
# The number of rows of a tree's node; the row with the codes of its children; the root of an empty tree.
NODE_ROWS, CHILD, NO_NODE = 7, 6, -1
# The place of a node is PLACES times the number of its seven rows, plus its kind: the AABBs of eight children, the first eight
# points of a cloud, or the second eight. The last row of a node of points holds the row of the cloud's ball in the table of
# solids, and the radius of a ball with the margin for contacts [m].
PLACES = 4
CHILDREN, FIRST_POINTS = 0, 1
BALL_ROW, BALL_REACH = 0, 1
NOWHERE = 1e300  # a bound, or a coordinate, that overlaps nothing [m]
# The number of a solid is a row of the table, or from here on the number of a ball: 16 times the number of its seven rows, plus
# its place among these sixteen.
FIRST_BALL = 1 << 44
