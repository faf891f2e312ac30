"""What the collision kernels write: status codes and columns. Plain numbers only. Used by them, the drivers and ``collision``."""

# Overlap of one configuration.
FREE, OVERLAPS, OUT_OF_RANGE = 0, 1, 2
# Of the nearest pair: its distance [m], infinite if there is no pair; the body of the robot; the other body, or the object,
# numbered from the last body on.
NEAREST, BODY, OTHER = 0, 1, 2
NEAREST_WIDTH = 3
# Columns of a contact: the signed distance [m], the two witness points [m] and the normal from the first body to the second.
DISTANCE, WITNESS_A, WITNESS_B, NORMAL = 0, 1, 4, 7
CONTACT_WIDTH = 10
# Of an edge between two configurations.
EDGE_FREE, EDGE_CONTACT, EDGE_OUT_OF_RANGE = 0, 1, 2
