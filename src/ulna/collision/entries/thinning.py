"""Chooses one point for each occupied voxel of a grid: the one nearest to its center.

1. The voxel of a point is three integers. Occupied voxels are numbered as they are found, and a hash table maps each to its
   number. When the table is half full, its entries move to one four times as large.
2. When all points are in it, each point is compared with the kept point of its voxel.

The caller owns the arrays, and passes some points at a time, since Python notices Ctrl-C between two calls.

Source: Teschner and others, Optimized spatial hashing for collision detection of deformable objects (VMV 2003), for the hash.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.decorators import entry, kernel
from ulna.engine.signatures import INDICES, NUMBER, NUMBERS, POINTS, POINTS_32, Group

VOXEL_BITS = 21  # of the number of a voxel along each axis
FIRST_SIZE = 1 << 10
FREE_SLOT = 0
BLOCK = 256  # points
_MASK = (1 << VOXEL_BITS) - 1


class Voxels(NamedTuple):
    """The occupied voxels, at most one for each point, shape (n,) each."""

    numbers: NDArray[np.int64]
    nearest: NDArray[np.int64]
    """The point nearest to the center of each."""
    squares: NDArray[np.float64]
    """The square of its distance, in units of the voxel's edge."""
    voxel_of_point: NDArray[np.int64]
    """The voxel of each point."""


_VOXELS = Group((INDICES, INDICES, NUMBERS, INDICES), Voxels)


@entry(*((points, NUMBER, NUMBERS, INDICES, _VOXELS, INDICES) for points in (POINTS, POINTS_32)))
def fill_slots(points, voxel, low, slots, voxels, progress):
    """Find the voxels of points, shape (n, 3), until the table is half full.

    voxel: The edge of a voxel [m]. low: The minimum x, y, z, where the grid begins; it has fewer than 2^21 voxels along each
    axis. slots: The hash table, shape (2^k,), of indices into ``Voxels``, counted from 1. progress: The first point, the one
    after the last, and the number of voxels. The next point to process and the new number of voxels replace them.
    """
    numbers_of_voxels, nearest, squares, voxel_of_point = voxels
    scale, max_voxels, end, voxel_row = 1.0 / voxel, slots.shape[0] // 2, progress[1], -1
    numbers_of_block, squares_of_block = np.empty(BLOCK, np.int64), np.empty(BLOCK)
    while progress[0] < end:
        first = progress[0]
        n = min(BLOCK, end - first)
        for i in range(n):  # many loads of slots are in flight at once: no branch waits for one of them
            numbers_of_block[i], squares_of_block[i] = voxel_of(points, first + i, scale, low)
            voxel_of_point[first + i] = slots[first_slot(slots, numbers_of_block[i])] - 1
        for i in range(n):
            number, k = numbers_of_block[i], first + i
            if voxel_row < 0 or numbers_of_voxels[voxel_row] != number:  # otherwise it is the previous point's voxel
                voxel_row = voxel_of_point[k]
                if voxel_row < 0 or numbers_of_voxels[voxel_row] != number:
                    slot = slot_of(slots, numbers_of_voxels, number)
                    voxel_row = slots[slot] - 1
                    if voxel_row < 0:
                        voxel_row = progress[2]
                        if voxel_row == max_voxels:
                            progress[0] = k
                            return
                        progress[2] = slots[slot] = voxel_row + 1
                        numbers_of_voxels[voxel_row], squares[voxel_row] = number, np.inf
            voxel_of_point[k] = voxel_row
            if squares_of_block[i] < squares[voxel_row]:
                nearest[voxel_row], squares[voxel_row] = k, squares_of_block[i]
        progress[0] += n


@entry((INDICES, INDICES))
def move_slots(voxels, slots):
    """Insert voxels, by their numbers, into an empty table."""
    for k in range(voxels.shape[0]):
        slots[slot_of(slots, voxels, voxels[k])] = k + 1


@entry(*((points, INDICES, INDICES, INDICES, NUMBERS) for points in (POINTS, POINTS_32)))
def measure_thinning(points, nearest, voxel_of_point, progress, farthest):
    """Write the maximum distance of points from the kept points of their voxels, over points from ``progress[0]`` on.

    The last point is before ``progress[1]``. ``farthest``, shape (1,), is raised to it [m]; other arguments as for
    ``fill_slots``.
    """
    max_square = 0.0
    for i in range(progress[0], progress[1]):
        k = nearest[voxel_of_point[i]]
        x, y, z = difference(points, i, k, 0), difference(points, i, k, 1), difference(points, i, k, 2)
        max_square = max(max_square, x * x + y * y + z * z)
    farthest[0] = max(farthest[0], np.sqrt(max_square))


@kernel
def difference(points, i, k, axis):
    """The difference of two points along an axis [m], as float64: ``float`` would leave a float32 as it is."""
    return np.float64(points[i, axis]) - np.float64(points[k, axis])


@kernel
def voxel_of(points, i, scale, low):
    """The number of a point's voxel, and the point's squared distance from its center in units of the edge."""
    x, y, z = (points[i, 0] - low[0]) * scale, (points[i, 1] - low[1]) * scale, (points[i, 2] - low[2]) * scale
    a, b, c = int(x), int(y), int(z)
    x, y, z = x - a - 0.5, y - b - 0.5, z - c - 0.5
    return (a << VOXEL_BITS | b) << VOXEL_BITS | c, x * x + y * y + z * z


@kernel
def first_slot(slots, number):
    """The first slot to try for a voxel."""
    a, b, c = number >> 2 * VOXEL_BITS, number >> VOXEL_BITS & _MASK, number & _MASK
    return (a * 73856093 ^ b * 19349663 ^ c * 83492791) & slots.shape[0] - 1


@kernel
def slot_of(slots, voxels, number):
    """The slot of a voxel in the table, or the free slot where it belongs."""
    slot = first_slot(slots, number)
    while slots[slot] != FREE_SLOT and voxels[slots[slot] - 1] != number:
        slot = slot + 1 & slots.shape[0] - 1
    return slot
