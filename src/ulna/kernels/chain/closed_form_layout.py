"""Numbers the rows of a closed form's table, and the families.

The arm in its zero configuration is a product of exponentials: the motion G(q) = T(q) T(0)^-1 of the end is the product of six
joint motions, the last joint's first. All vectors are in the base's axes. Lengths are shares of the reach, so one threshold
serves every arm.

========= ==========================================================================================================
AXES      six rows: unit vectors h_1 .. h_6.
POINTS    six rows: P_0, a point on the first axis, then P_i, from the point on axis i to the one on axis i + 1.
LAST      the point on the last axis.
FRAME     four rows: the columns of T(0)^-1: its three axes and its origin.
NORMALS   six rows: for each of h_2, h_4 and h_6 a unit normal n, and h x n; with h they are the columns of its frame F.
FIFTH     nine rows: the matrix F' rot(h_5, q_5) F_6 is K + C cos q_5 + S sin q_5; F is F_2 for three parallel axes, else F_4;
          three rows each of K, C and S.
BENDS     1 - cos(a - b) and 1 + cos(a + b): a and b are the angles of h_5 with h_2 or h_4, and with h_6; and FREE_WRIST (1: the
          last three angles are free, so their accuracy and distance do not matter).
FORM      FAMILY, REVERSED (1: the chain is seen from its end, so G is inverted), INVERSE_REACH [1/m].
COLUMNS   two rows: the entry of q that each axis reads.
SIGNS     two rows: 1 or -1: q = sign times the angle; for a prismatic joint 1 or -1 times the reach [m].
POLISH    MIN_ERROR (a lower bound of a branch's error, for axes only nearly of the family), MAX_ERROR and STEPS of ``polish``
========= ==========================================================================================================
"""

AXES, POINTS, LAST, FRAME, NORMALS, FIFTH, BENDS, FORM, COLUMNS, SIGNS, POLISH = 0, 6, 12, 13, 17, 23, 32, 33, 34, 36, 38
N_ROWS = 39
OF_2, OF_4, OF_6 = 0, 2, 4  # rows of NORMALS
MIN_ERROR, MAX_ERROR, STEPS = 0, 1, 2  # entries of POLISH
FAMILY, REVERSED, INVERSE_REACH = 0, 1, 2  # entries of FORM
FREE_WRIST = 2  # entry of BENDS
# Three parallel axes between a first one and two that intersect; and a spherical wrist behind axes 1, 2 and 3, two of which
# are parallel or intersect.
THREE_PARALLEL, PARALLEL_23, INTERSECTING_12, PARALLEL_12, INTERSECTING_23 = 0, 1, 2, 3, 4
# A spherical wrist behind prismatic and revolute joints: one prismatic before or behind two axes; two behind or before one; all.
SLIDE_PARALLEL_23, SLIDE_INTERSECTING_23, INTERSECTING_12_SLIDE, PARALLEL_12_SLIDE = 5, 6, 7, 8
TURN_SLIDES, SLIDES_TURN, THREE_SLIDES = 9, 10, 11
# Three parallel axes between a first one and two skew ones; and a spherical wrist behind any three axes.
OFFSET_HAND, ANY_THREE_AXES = 12, 13
N_BRANCHES = 8
# Properties of a branch: its residual as a share of the reach or in radians; the accuracy of its least determined angle; the
# distance of its nearest pair of roots, as a signed square (``accuracy``), negative for a complex pair.
RESIDUAL, DETERMINED, SEPARATION = 0, 1, 2
N_KNOWN = 3
# The same in one number, as a sum of these flags.
IS_REAL, IS_HARDLY_DETERMINED, IS_COINCIDING, IS_WITHIN = 1, 2, 4, 8  # real; ...; within bounds
# The proof by the branches of a target: they are all; all, and two coincide; there are infinitely many; no proof.
COMPLETE, COINCIDE, CONTINUUM, UNPROVED = 0, 1, 2, 3
REACHED = 1e-9  # maximum RESIDUAL of a branch
ENOUGH = 1e-12  # RESIDUAL below which a step of ``polish`` is not worth its time
# A joint is at its limit if it exceeds the limit by at most the first [rad, or a share of the reach if prismatic]. Beyond the
# second it is not, however inaccurate its angle is (``move_to_limits``).
AT_LIMIT, HARDLY_BEYOND = 1e-9, 1e-3
N_BOUNDS = 5  # numbers that bound each joint (``nearest_branch``)
# Thresholds of DETERMINED, the fourth power of a sine or of a share of the reach: below the first an angle is undetermined;
# below the second possibly so, since the rounding of other angles may have made it that large.
UNDETERMINED, HARDLY_DETERMINED = 1e-44, 1e-36
# Thresholds of SEPARATION, the fourth power of the sine of half an angle: one solution, and a certainly complex pair.
COINCIDING, COMPLEX = 1e-24, -1e-16
