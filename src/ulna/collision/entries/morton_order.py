"""Sorts points along a Morton curve, so that neighbors in the order are neighbors in space.

1. The cube that holds the points is cut into 2^b cells along each axis. The cell of a point is three numbers of b bits.
2. Their interleaved bits are the point's code. A key is the code followed by the point's number. Keys are radix-sorted by their
   codes, the least significant digit first.
3. The points of a cell with more than CROWD points are sorted again within their own cube. A few distant points then do not push
   all the others into one cell.

Source: Morton, A computer oriented geodetic data base (IBM, 1966); Karras, Maximizing parallelism in the construction of BVHs
(HPG 2012), for its use in a tree.
"""

from typing import Any, NamedTuple

import numpy as np

from ulna.engine.decorators import entry, kernel, routine, workspace
from ulna.engine.signatures import INDICES, POINTS, POINTS_32

FEW, SOME = 1 << 12, 1 << 19  # points: up to these numbers, cells are coarser
OF_FEW, OF_SOME, OF_MANY = (
    (6, 2),
    (8, 2),
    (10, 3),
)  # bits of a cell along each axis, and the number of digits for the radix sort
N_COUNTS, N_SPREAD = 3 << 12, 1 << 10
NUMBER_BITS = 30  # bits of a point's number in a key: a tree has fewer than 2^30 points
NUMBER = (1 << NUMBER_BITS) - 1
CROWD = 64
_NO_EXTENT = 1e-290  # [m]: a cube no larger is not cut


class Grid(NamedTuple):
    """The cells of a cube."""

    low: Any
    """The minimum x, y, z of the points [m]."""
    scale: float
    """One over the edge of a cell [1/m]."""
    bits: int
    """Bits of the cell's number along each axis."""
    digit_bits: int
    """Bits of a digit of the code."""


@entry((POINTS, INDICES), (POINTS_32, INDICES))
def morton_order(points, order):
    """Write the Morton order of points, shape (n, 3), to order, shape (n,)."""
    keys = sorted_keys(points)
    for i in range(order.shape[0]):
        order[i] = keys[i] & NUMBER


@workspace
def sorted_keys(points):
    """The sorted keys of points, shape (n, 3): shape (n,). ``key & NUMBER`` is the number of a point."""
    n = points.shape[0]
    keys, spare = np.empty(n, np.int64), np.empty(n, np.int64)
    counts, spread = np.empty(N_COUNTS, np.int64), np.empty(N_SPREAD, np.int64)
    for i in range(N_SPREAD):
        spread[i] = spread_bits(i)
    for i in range(n):
        keys[i] = i
    if n > 0:
        sort_part(points, keys, spare, counts, spread, 0, n)
    first = 0
    while first < n:
        end = first + 1
        while end < n and keys[end] >> NUMBER_BITS == keys[first] >> NUMBER_BITS:
            end += 1
        if end - first <= CROWD or not sort_part(points, keys, spare, counts, spread, first, end):
            first = end
    return keys


@routine
def sort_part(points, keys, spare, counts, spread, first, end):
    """Sort the keys from ``first`` to before ``end``; False, without a change, if all points coincide."""
    low, high = bounds_of_keys(points, keys, first, end)
    widest = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
    if not widest > _NO_EXTENT:
        return False
    n = end - first
    bits, n_digits = OF_FEW if n <= FEW else OF_SOME if n <= SOME else OF_MANY
    digit_bits = 3 * bits // n_digits
    grid = Grid(low, ((1 << bits) - 1) / widest, bits, digit_bits)
    if n_digits == 2:
        write_codes(points, keys, keys, counts, spread, (first, end), grid)
    else:
        write_codes(points, keys, spare, counts, spread, (first, end), grid)
        move_by_digit(spare, keys, counts, first, end, 0, digit_bits)
    move_by_digit(keys, spare, counts, first, end, n_digits - 2, digit_bits)
    move_by_digit(spare, keys, counts, first, end, n_digits - 1, digit_bits)
    return True


@routine
def bounds_of_keys(points, keys, first, end):
    """The minimum and maximum x, y, z of the points of some keys."""
    k = keys[first] & NUMBER
    x, y, z = np.float64(points[k, 0]), np.float64(points[k, 1]), np.float64(points[k, 2])
    low_x, low_y, low_z, high_x, high_y, high_z = x, y, z, x, y, z
    for i in range(first, end):
        k = keys[i] & NUMBER
        x, y, z = np.float64(points[k, 0]), np.float64(points[k, 1]), np.float64(points[k, 2])
        low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
        high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
    return (low_x, low_y, low_z), (high_x, high_y, high_z)


@routine
def write_codes(points, source, keys, counts, spread, part, grid):
    """Write the codes of some keys, and count the keys by the value of each digit, up to three digits.

    part: The first of the keys, and the one after the last.
    """
    (first, end), (low, scale, bits, digit_bits) = part, grid
    most, mask, size = (1 << bits) - 1, (1 << digit_bits) - 1, 1 << digit_bits
    for i in range(3 * size):
        counts[i] = 0
    for i in range(first, end):
        k = source[i] & NUMBER
        x, y, z = np.float64(points[k, 0]) - low[0], np.float64(points[k, 1]) - low[1], np.float64(points[k, 2]) - low[2]
        cell_x, cell_y, cell_z = min(int(x * scale), most), min(int(y * scale), most), min(int(z * scale), most)
        code = spread[cell_x] << 2 | spread[cell_y] << 1 | spread[cell_z]
        keys[i] = code << NUMBER_BITS | k
        counts[code & mask] += 1
        counts[size + (code >> digit_bits & mask)] += 1
        counts[2 * size + (code >> 2 * digit_bits)] += 1


@kernel
def spread_bits(x):
    """The bits of a number of at most ten bits, with two zeros between neighbors."""
    x = (x | x << 16) & 0x30000FF
    x = (x | x << 8) & 0x300F00F
    x = (x | x << 4) & 0x30C30C3
    return (x | x << 2) & 0x9249249


@routine
def move_by_digit(keys, target, counts, first, end, digit, digit_bits):
    """Sort some keys by one digit of their codes into a target. Keys with equal digits keep their order."""
    start, at = digit << digit_bits, first
    for i in range(start, start + (1 << digit_bits)):
        count = counts[i]
        counts[i] = at
        at += count
    shift, mask = NUMBER_BITS + digit * digit_bits, (1 << digit_bits) - 1
    for i in range(first, end):
        key = keys[i]
        place = start + (key >> shift & mask)
        target[counts[place]] = key
        counts[place] += 1
