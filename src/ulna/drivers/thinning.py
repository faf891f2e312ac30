"""Chooses of the points in each voxel of a grid the one nearest to its middle.

1. The voxel of a point is three whole numbers. A hash table has a slot for each voxel with points, with the nearest one so far.
   When it is half full, all slots are moved to a table four times as large.
2. When all points are in it, each is compared with the one that is kept in its voxel.

The caller owns the tables, and calls for some points at a time, since Python notices Ctrl-C between two calls.

Source: Teschner and others, Optimized spatial hashing for collision detection of deformable objects (VMV 2003), for the hash.
"""

import numpy as np

from ulna.engine.decorators import entry, kernel
from ulna.engine.signatures import INDICES, NUMBER, NUMBERS, POINTS, POINTS_32, TRUTHS

VOXEL_BITS = 21  # of the number of a voxel along each axis
FIRST_SIZE = 1 << 10
FREE_SLOT = -1


@entry(*((points, NUMBER, NUMBERS, INDICES, INDICES, INDICES) for points in (POINTS, POINTS_32)))
def fill_slots(points, voxel, low, voxels, nearest, progress):
    """Put points, shape (n, 3), into a table until it is half full.

    low: the least x, y, z, where the grid begins; it has fewer than 2^21 voxels of this edge [m] along each axis. voxels and
    nearest: the table, shape (2^k,). progress: the first of the points, the one after the last, and how many voxels the table
    has; where to go on, and how many it has then, are written in their place.
    """
    scale, most, count = 1.0 / voxel, voxels.shape[0] // 2, progress[2]
    for i in range(progress[0], progress[1]):
        a, b, c, square = voxel_of(points, i, scale, low)
        number, slot = slot_of(voxels, a, b, c)
        if voxels[slot] == FREE_SLOT:
            if count == most:
                progress[0], progress[2] = i, count
                return
            voxels[slot], nearest[slot], count = number, i, count + 1
        else:
            k = nearest[slot]
            if square < voxel_of(points, k, scale, low)[3]:
                nearest[slot] = i
    progress[0], progress[2] = progress[1], count


@entry((INDICES, INDICES, INDICES, INDICES))
def move_slots(voxels, nearest, more, nearest_of_more):
    """Put all voxels of a table into a larger one."""
    mask = (1 << VOXEL_BITS) - 1
    for i in range(voxels.shape[0]):
        number = voxels[i]
        if number != FREE_SLOT:
            _, slot = slot_of(more, number >> 2 * VOXEL_BITS, number >> VOXEL_BITS & mask, number & mask)
            more[slot], nearest_of_more[slot] = number, nearest[i]


@entry(*((points, NUMBER, NUMBERS, INDICES, INDICES, INDICES, TRUTHS) for points in (POINTS, POINTS_32)))
def compare_with_kept(points, voxel, low_and_farthest, voxels, nearest, progress, kept):
    """Write which points from ``progress[0]`` to before ``progress[1]`` are kept, shape (n,).

    low_and_farthest: as ``low`` of ``fill_slots``, and how far any is from the one that is kept in its voxel [m], if that is
    farther than what is there, shape (4,).
    """
    scale, farthest = 1.0 / voxel, 0.0
    for i in range(progress[0], progress[1]):
        a, b, c, _ = voxel_of(points, i, scale, low_and_farthest)
        _, slot = slot_of(voxels, a, b, c)
        k = nearest[slot]
        x, y, z = apart(points, i, k, 0), apart(points, i, k, 1), apart(points, i, k, 2)
        farthest = max(farthest, x * x + y * y + z * z)
        kept[i] = k == i
    low_and_farthest[3] = max(low_and_farthest[3], np.sqrt(farthest))


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
    number, mask = (a << VOXEL_BITS | b) << VOXEL_BITS | c, voxels.shape[0] - 1
    slot = (a * 73856093 ^ b * 19349663 ^ c * 83492791) & mask
    while voxels[slot] != FREE_SLOT and voxels[slot] != number:
        slot = slot + 1 & mask
    return number, slot
