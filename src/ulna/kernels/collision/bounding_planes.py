"""Keeps bounding planes of a body, which show that most points of a cloud are far from it.

The points x of a body satisfy n . x <= offset, along any direction n. So the distance of a ball, or of an AABB, from this plane
is a lower bound of its distance from the body. The contact of one point of a cloud gives the normal of such a plane. The plane
bounds the distances of neighboring points, so only a few points have to be measured. For a box its own faces are as good a bound,
but not for a hull or a cylinder. Planes are in the body's frame, so they are valid at every q.
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
    """Keep the plane of our body with this normal, in the base frame; it replaces the oldest of many planes.

    Planes are kept only for pairs whose distance needs a search. vertices, points: The vertices of the two bodies.
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
    """Lower bound on an AABB's distance from the planes of body k at pose a [m]; -inf without planes.

    x: The AABB's center, in the body's frame. half: Its half extents.
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
