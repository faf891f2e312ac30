"""Numbers the columns of the flat tables that hold a robot.

Plain numbers only, so that descriptions can be read without a compiler.

Every robot has tables of the same layout, so the kernels are compiled once. A row of the table of joints is a moving joint.
It rotates about, or slides along, the z axis of its own frame (``kinematics.tree`` rotates the frames so that this holds):

====== =========================================================================================================
0..11  T_parent_joint at zero, a pose (see the package): the joint's frame in the frame of the joint before it
KIND   REVOLUTE, PRISMATIC or FIXED (the last row of a chain: the constant offset of its link)
COLUMN the entry of q that drives the joint
RATIO  and OFFSET: the joint's angle or distance is RATIO * q[COLUMN] + OFFSET (a mimic joint has its own ratio)
PARENT the row of the joint before it, BASE for the first joint; in a chain always the row above
====== =========================================================================================================

A row of a table of frames (links, or collision shapes) is a frame fixed to a joint: 0..11 its pose in the
joint's frame, JOINT the joint's row or BASE, AT_JOINT 1 if that pose is the identity.

A row of a table of bodies is a frame with a shape. A solid of the world is fixed to the base. In the column JOINT it has OBJECT,
the number of its object. In AT_JOINT it has TOUCH_SET, the set of links that may touch it (``kernels.collision``).
A shape is a core and a ball of RADIUS that sweeps it: a sphere is a point, and a capsule a segment, with a radius.

============ ===================================================================================================
SHAPE        SPHERE, CAPSULE, BOX, CYLINDER, HULL or HALF_SPACE
HALF_EXTENTS three numbers: half the edges [m] of the smallest box around the core that is centered at the frame's origin. They
             determine a box, a point (0, 0, 0), a segment along z (0, 0, h) and a cylinder (r, r, h).
RADIUS       the radius of the ball that sweeps the core [m]
FIRST_VERTEX and N_VERTICES: the rows of a hull's points in the table's array of vertices, shape (m, 3)
REACH        the radius of a ball about the frame's origin that contains the body [m]; infinite for a half-space
============ ===================================================================================================

A row of a table of inertias has the body that a joint carries: all links that are fixed to that joint, in the joint's frame.

====== =========================================================================================================
MASS   [kg]
MOMENT three numbers: mass times center of mass [kg m]
TENSOR six numbers: xx, xy, xz, yy, yz, zz of the inertia tensor about the origin of the joint's frame [kg m^2]
====== =========================================================================================================

A half-space contains every point below the plane z = 0 of its frame. Its z axis is the outward normal. It has no extents.
"""

KIND, COLUMN, RATIO, OFFSET, PARENT = 12, 13, 14, 15, 16
TABLE_WIDTH = 17
REVOLUTE, PRISMATIC, FIXED = 0, 1, 2
BASE = -1
JOINT, AT_JOINT = 12, 13
OBJECT, TOUCH_SET = 12, 13
FRAME_WIDTH = 14
SHAPE, HALF_EXTENTS, RADIUS, FIRST_VERTEX, N_VERTICES, REACH = 14, 15, 18, 19, 20, 21
BODY_WIDTH = 22
MASS, MOMENT, TENSOR = 0, 1, 4
INERTIA_WIDTH = 10
SPHERE, CAPSULE, BOX, CYLINDER, HULL, HALF_SPACE = 0, 1, 2, 3, 4, 5  # a pair is computed with the lower number first
CONTACT = 1e-12  # of the sizes of two bodies, added up: no farther apart than this they touch, and their distance is zero
IN_BASE, IN_LINK, IN_SPATIAL = 0, 1, 2  # the frames in which a Jacobian may be expressed
LARGEST_DEFECT = 1e-6  # of a pose that comes in from a rigid motion
EXACT_DEFECT = 5e-15  # of a pose that is kept as it is: half of what makes it be rounded, so that no sum's own rounding counts
LARGEST = 1e6  # of a joint position or a coordinate: beyond it sincos' range reduction, and the caller's own number, lose digits
