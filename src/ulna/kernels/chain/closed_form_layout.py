"""Numbers the rows of the table of a closed form and its families.

The arm in its zero configuration, as a product of exponentials: the motion G(q) = T(q) T(0)^-1 of the end is that of six turns,
the last first. All vectors are in the base's axes. Lengths are shares of the reach, so that one threshold serves every arm.

========= ==========================================================================================================
AXES      six rows: unit vectors h_1 .. h_6
POINTS    six rows: P_0, a point on the first axis, then P_i, from the point on axis i to the one on axis i + 1
LAST      the point on the last axis
FRAME     four rows: the columns of T(0)^-1: its three axes and its origin
NORMALS   six rows: of h_2, h_4 and h_6 in turn a unit vector n normal to it, and h x n: with h the columns of its frame F
FIFTH     nine rows: the matrix F' rot(h_5, q_5) F_6 is K + C cos q_5 + S sin q_5, and F is F_2 for three parallel axes, else F_4;
          three rows each of K, C and S
BENDS     1 - cos(a - b) and 1 + cos(a + b): a and b are the angles of h_5 with h_2 or h_4, and with h_6; and FREE_WRIST (1: the
          last three angles are free, so it does not matter how well they are determined, or how far apart)
FORM      FAMILY, REVERSED (1: the chain is seen from its end, so G is inverted), INVERSE_REACH [1/m]
COLUMNS   two rows: which entry of q each axis turns
SIGNS     two rows: 1 or -1: q = sign times the angle; for a joint that slides 1 or -1 times the reach [m]
POLISH    MIN_ERROR (that a branch has for certain, where the axes are nearly of the family), MAX_ERROR and STEPS of ``polish``
========= ==========================================================================================================
"""

AXES, POINTS, LAST, FRAME, NORMALS, FIFTH, BENDS, FORM, COLUMNS, SIGNS, POLISH = 0, 6, 12, 13, 17, 23, 32, 33, 34, 36, 38
N_ROWS = 39
OF_2, OF_4, OF_6 = 0, 2, 4  # rows of NORMALS
MIN_ERROR, MAX_ERROR, STEPS = 0, 1, 2  # entries of POLISH
FAMILY, REVERSED, INVERSE_REACH = 0, 1, 2  # entries of FORM
FREE_WRIST = 2  # entry of BENDS
# Three parallel axes between a first one and two that intersect; and a spherical wrist behind the axes 1, 2 and 3, of which two
# are parallel or intersect.
THREE_PARALLEL, PARALLEL_23, INTERSECTING_12, PARALLEL_12, INTERSECTING_23 = 0, 1, 2, 3, 4
# A spherical wrist behind joints of which some slide: one, before or behind two axes; two, behind or before one; three.
SLIDE_PARALLEL_23, SLIDE_INTERSECTING_23, INTERSECTING_12_SLIDE, PARALLEL_12_SLIDE = 5, 6, 7, 8
TURN_SLIDES, SLIDES_TURN, THREE_SLIDES = 9, 10, 11
# Three parallel axes between a first one and two that pass each other; and a spherical wrist behind any three axes.
OFFSET_HAND, ANY_THREE_AXES = 12, 13
N_BRANCHES = 8
# What is known of a branch: its largest error as a share of the reach or in radians; how well its worst determined angle is
# determined; how far its nearest pair of angles is apart, as a signed square (``accuracy``), below 0 where it is complex.
RESIDUAL, DETERMINED, APART = 0, 1, 2
N_KNOWN = 3
# That in one number, a sum of these.
IS_REAL, IS_HARDLY_DETERMINED, IS_COINCIDING, IS_WITHIN = 1, 2, 4, 8  # real; ...; within bounds
# What the branches of a target prove: that they are all; all, and two are one; that there are infinitely many; nothing.
COMPLETE, COINCIDE, CONTINUUM, UNPROVED = 0, 1, 2, 3
REACHED = 1e-9  # largest RESIDUAL of a branch
ENOUGH = 1e-12  # of RESIDUAL: below it a step of ``polish`` is not worth its time
# No further beyond a limit than the first a joint is at it [rad, or of a slide a share of the reach]; further than the second it
# is not, however little is known of its angle (``put_at_limits``).
AT_LIMIT, HARDLY_BEYOND = 1e-9, 1e-3
N_BOUNDS = 5  # numbers of each joint that bound it (``nearest_branch``)
# Of DETERMINED, which is the fourth power of a sine or of a share of the reach: below the first an angle counts as
# undetermined, below the second as possibly so: the rounding of other angles may have made it that large.
UNDETERMINED, HARDLY_DETERMINED = 1e-44, 1e-36
# Of APART, which is the fourth power of the sine of half an angle: of one solution, and of a pair that is complex for certain.
COINCIDING, COMPLEX = 1e-24, -1e-16
