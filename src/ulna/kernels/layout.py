"""The robot as flat tables: what their columns mean. Plain numbers only, so that the model can read them without a compiler.

One table serves every robot, so one compilation does. A row of the table of joints is a moving joint, which acts about or
along the z axis of its own frame (the model turns the frames so that this holds):

====== =========================================================================================================
0..11  T_parent_joint at zero, a pose (see the package): where the joint stands in the frame of the joint before it
KIND   REVOLUTE, PRISMATIC or FIXED (the last row of a chain: the link's own offset, which no joint moves)
COLUMN which entry of q drives it
RATIO  and OFFSET: the joint's angle or distance is RATIO * q[COLUMN] + OFFSET (a mimic joint has its own ratio)
PARENT the row of the joint before it, BASE for the first; in a chain always the row above
====== =========================================================================================================

A row of a table of frames (links, or collision shapes) is a frame that stands still relative to a joint: 0..11 its pose in the
joint's frame, JOINT the joint's row or BASE, AT_JOINT 1 if that pose is the identity. A table of boxes has the columns of
a table of frames and then the half extents [m] from HALF_EXTENTS on; a box of the world hangs on the BASE.
"""

KIND, COLUMN, RATIO, OFFSET, PARENT = 12, 13, 14, 15, 16
TABLE_WIDTH = 17
REVOLUTE, PRISMATIC, FIXED = 0, 1, 2
BASE = -1

JOINT, AT_JOINT = 12, 13
FRAME_WIDTH = 14

HALF_EXTENTS = FRAME_WIDTH
BOX_WIDTH = FRAME_WIDTH + 3

LARGEST_DEFECT = 1e-6  # of a pose that comes in from a rigid motion
LARGEST = 1e6  # of a joint position or a coordinate: beyond it sincos' range reduction, and the caller's own number, lose digits
