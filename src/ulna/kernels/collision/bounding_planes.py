"""Keeps planes that have a body on one side, which show that much of a cloud is far from it.

For the points x of a body n . x <= offset, along any direction n. So a ball, or an AABB, is at least as far from the body as it
is beyond that plane. The distance of one point of a cloud gives the normal of such a plane, and this bounds the distances of the
points beside it: few of many points have to be measured. The box round a body is as good a bound for a box, but not for a hull or
a cylinder. Planes are in the body's frame, so they are true at every q.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import splat
from ulna.kernels.collision.collision_layout import NORMAL, PLANE_NORMAL, PLANE_OFFSET, PLANES
from ulna.kernels.collision.posed_pair import convex_body, gap_is_searched
from ulna.kernels.distance.support import support
from ulna.kernels.layout import CONTACT, HALF_EXTENTS, RADIUS
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.vectors import dot, rotate, rotate_inverse


@kernel
def add_plane(vertices, points, ours, theirs, planes, normal):
    """Keep the plane of a normal, in the base frame, beside our body, in place of its oldest one if there are many.

    Only where the distance of the two bodies is searched. vertices, points: those of the two.
    """
    if vertices is None or points is None:
        return
    if gap_is_searched(ours, theirs):
        write_plane(ours, planes, normal)


@routine
def write_plane(ours, planes, normal):
    """Write a plane to the rows of a body."""
    k, table, n = ours.row, ours.table, rotate_inverse(ours.pose, normal)
    body, c = convex_body(ours), HALF_EXTENTS
    size = table[k, RADIUS] + table[k, c] + table[k, c + 1] + table[k, c + 2]
    row = PLANES * k + planes.counts[k] % PLANES
    planes.rows[row, PLANE_NORMAL], planes.rows[row, PLANE_NORMAL + 1], planes.rows[row, PLANE_NORMAL + 2] = n
    planes.rows[row, PLANE_OFFSET] = dot(support(body.core, n), n) + table[k, RADIUS] + CONTACT * size
    planes.counts[k] += 1


@kernel
def beyond_planes(planes, k, a, x, half):
    """How far an AABB is beyond the planes of body k at pose a at least [m]; -inf without planes.

    x: its middle, in the body's frame; half: half its extents.
    """
    least = splat(-np.inf, x[0])
    for row in range(PLANES * k, PLANES * k + min(planes.counts[k], PLANES)):
        n = planes.rows[row, PLANE_NORMAL], planes.rows[row, PLANE_NORMAL + 1], planes.rows[row, PLANE_NORMAL + 2]
        turned = rotate(a, n)
        radius = abs(turned[0]) * half[0] + abs(turned[1]) * half[1] + abs(turned[2]) * half[2]
        least = maximum(least, dot(n, x) - (radius + planes.rows[row, PLANE_OFFSET]))
    return least


@kernel
def normal_of(contacts, row):
    """The normal of a contact."""
    return contacts[row, NORMAL], contacts[row, NORMAL + 1], contacts[row, NORMAL + 2]
