"""Chooses of the points in each voxel of a grid the one nearest to its middle.

1. The voxel of a point is three whole numbers. A hash table has a slot for each voxel with points, with the nearest one so far.
   When it is half full, all slots are moved to a table four times as large.
2. When all points are in it, each is compared with the one that is kept in its voxel.

Source: Teschner and others, Optimized spatial hashing for collision detection of deformable objects (VMV 2003), for the hash.
"""

import numpy as np

from ulna.engine.decorators import entry, kernel, routine
from ulna.engine.signatures import NUMBER, NUMBERS, POINTS, POINTS_32, TRUTHS

VOXEL_BITS = 21  # of the number of a voxel along each axis
FIRST_SIZE = 1 << 12
_FREE = -1


@entry(*((points, NUMBER, NUMBERS, TRUTHS) for points in (POINTS, POINTS_32)))
def thin(points, voxel, low_and_farthest, kept):
    """Write which points, shape (n, 3), are kept, shape (n,), and how far any is from the one kept in its voxel [m].

    low_and_farthest: the least x, y, z, where the grid begins; the distance is written behind them, shape (4,). The grid has
    fewer than 2^21 voxels along each axis.
    """
    scale, n, start, count = 1.0 / voxel, points.shape[0], 0, 0
    voxels, nearest = np.full(FIRST_SIZE, _FREE, np.int64), np.empty(FIRST_SIZE, np.int64)
    while start < n:
        start, count = fill_slots(points, scale, low_and_farthest, voxels, nearest, start, count)
        if start < n:
            size = 4 * voxels.shape[0]
            more, nearest_of_more = np.full(size, _FREE, np.int64), np.empty(size, np.int64)
            move_slots(voxels, nearest, more, nearest_of_more)
            voxels, nearest = more, nearest_of_more
    low_and_farthest[3] = np.sqrt(compare_with_kept(points, scale, low_and_farthest, voxels, nearest, kept))


@routine
def fill_slots(points, scale, low, voxels, nearest, start, count):
    """Put the points from ``start`` on into a table with so many voxels, until it is half full; where to go on, and how many."""
    most = voxels.shape[0] // 2
    for i in range(start, points.shape[0]):
        a, b, c, square = voxel_of(points, i, scale, low)
        voxel, slot = slot_of(voxels, a, b, c)
        if voxels[slot] == _FREE:
            if count == most:
                return i, count
            voxels[slot], nearest[slot], count = voxel, i, count + 1
        else:
            k = nearest[slot]
            if square < voxel_of(points, k, scale, low)[3]:
                nearest[slot] = i
    return points.shape[0], count


@routine
def move_slots(voxels, nearest, more, nearest_of_more):
    """Put all voxels of a table into a larger one."""
    mask = (1 << VOXEL_BITS) - 1
    for i in range(voxels.shape[0]):
        voxel = voxels[i]
        if voxel != _FREE:
            _, slot = slot_of(more, voxel >> 2 * VOXEL_BITS, voxel >> VOXEL_BITS & mask, voxel & mask)
            more[slot], nearest_of_more[slot] = voxel, nearest[i]


@routine
def compare_with_kept(points, scale, low, voxels, nearest, kept):
    """Write which points are kept; the square of how far any is at most from the one kept in its voxel."""
    farthest = 0.0
    for i in range(points.shape[0]):
        a, b, c, _ = voxel_of(points, i, scale, low)
        _, slot = slot_of(voxels, a, b, c)
        k = nearest[slot]
        x, y, z = apart(points, i, k, 0), apart(points, i, k, 1), apart(points, i, k, 2)
        farthest = max(farthest, x * x + y * y + z * z)
        kept[i] = k == i
    return farthest


@kernel
def apart(points, i, k, axis):
    """How far two points are apart along an axis [m]; ``float`` would leave a float32 as it is."""
    return np.float64(points[i, axis]) - np.float64(points[k, axis])


@kernel
def voxel_of(points, i, scale, low):
    """The voxel of a point, and the square of its distance from the middle, as a multiple of the voxel's edge."""
    x, y, z = (points[i, 0] - low[0]) * scale, (points[i, 1] - low[1]) * scale, (points[i, 2] - low[2]) * scale
    a, b, c = int(x), int(y), int(z)
    x, y, z = x - a - 0.5, y - b - 0.5, z - c - 0.5
    return a, b, c, x * x + y * y + z * z


@kernel
def slot_of(voxels, a, b, c):
    """The number of a voxel, and its slot in the table, or the free one where it belongs."""
    voxel, mask = (a << VOXEL_BITS | b) << VOXEL_BITS | c, voxels.shape[0] - 1
    slot = (a * 73856093 ^ b * 19349663 ^ c * 83492791) & mask
    while voxels[slot] != _FREE and voxels[slot] != voxel:
        slot = slot + 1 & mask
    return voxel, slot
