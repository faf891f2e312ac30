"""Builds the BVHs of clouds on a GPU, as the nodes that the CPU's kernels search (``kernels.collision.bvh``).

1. The extent of the points, block by block.
2. A key for each point: its Morton code, above its number.
3. The keys are sorted by the code, nine bits at a time, least digits first. A thread counts the digits of consecutive keys, one
   block accumulates the counts of all threads, and each thread moves its keys. So equal digits keep their order.
4. Eight consecutive points are a leaf, eight consecutive leaves a node, and so on up to the root, as in
   ``collision.entries.tree_nodes``. So the number of points gives the place of every node, and the host reads nothing back.

Sources: Morton, A computer oriented geodetic data base (IBM, 1966); for the sort Satish, Harris, Garland, Designing efficient
sorting algorithms for manycore GPUs (IPDPS 2009).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.entries.morton_order import NUMBER, NUMBER_BITS, spread_bits
from ulna.collision.entries.tree_nodes import clear_lane, write_lane_above
from ulna.collision.object_tree import max_cloud_nodes
from ulna.engine.lanes import WIDTH
from ulna.gpu import device
from ulna.gpu.device import THREADS, cuda
from ulna.kernels.collision.collision_layout import BALL_REACH, BALL_ROW, CHILD, FIRST_POINTS, NODE_ROWS, NOWHERE, PLACES
from ulna.kernels.layout import CONTACT

MAX_CLOUDS = WIDTH - 1  # in a BVH of their own: with the root of all other objects they are the children of one node
_BITS, _DIGIT, _N_DIGITS = 9, 9, 3  # bits of a cell along each axis; bits of a digit; digits of a code
_VALUES = 1 << _DIGIT
_SORTING, _SORTERS = 16, 2048  # threads of a block that sorts, whose counts fill its shared memory; threads that sort
_MIN_KEYS = 16  # keys of a thread that sorts
_EXTENTS = 64  # blocks that measure the extent, at most
_ALONE = 256  # threads of a launch of one block
_NO_EXTENT = 1e-290  # [m]: a smaller cube is one cell


class PlacedCloud(NamedTuple):
    """A cloud in a world.

    Attributes:
        cloud: Its points.
        T: T_base_cloud, shape (4, 4).
        row: The row of its ball in the table of solids.
    """

    cloud: PointCloud
    T: NDArray[np.float64]
    row: int

    @property
    def reach(self) -> float:
        """The radius of a ball, with the margin for contacts [m]."""
        return self.cloud.radius + CONTACT * self.cloud.radius

    @property
    def farthest(self) -> float:
        """Upper bound on the distance of the balls from the base's origin [m]."""
        points = self.cloud.points
        lengths = np.abs(points).max(axis=0, initial=0.0).astype(np.float64)
        return float(np.linalg.norm(self.T[:3, 3]) + np.linalg.norm(lengths) + self.reach)


class CloudTrees:
    """The BVHs of the clouds of a world, behind the arena's nodes in one array on the device.

    A cloud keeps its place as long as the places before it keep their sizes. Only clouds that changed are built again.
    """

    def __init__(self) -> None:
        self._nodes, self._built = None, []

    @staticmethod
    def room(clouds: tuple[PlacedCloud, ...]) -> int:
        """The number of nodes that clouds need, with one node to join them."""
        return 1 + sum(map(_room, clouds))

    def write(self, clouds: tuple[PlacedCloud, ...], others: int, nodes: Any, first: int, stream: Any) -> int:
        """Write the trees to nodes from number ``first`` on; the root of a tree over them and over the root ``others``."""
        if nodes is not self._nodes:
            self._nodes, self._built = nodes, []
        built, roots, at = [], [others] if others >= 0 else [], first + 1
        for k, placed in enumerate(clouds):
            built.append((placed.cloud, placed.T.tobytes(), placed.row, at))
            if built[k:] != self._built[k : k + 1]:
                write_tree(placed, nodes, at, stream)
            roots.append(PLACES * (at + _root(len(placed.cloud.points))))
            at += _room(placed)
        self._built = built
        if len(roots) == 1:
            return roots[0]
        filled = *roots, *(-1,) * (WIDTH - len(roots))
        device.compiled(join)[1, WIDTH, stream](filled, first, nodes)
        return PLACES * first


def _room(placed: PlacedCloud) -> int:
    """The number of nodes reserved for a cloud: the same for the next image of a camera."""
    return 1 << max_cloud_nodes(len(placed.cloud.points)).bit_length()


def _lowest(n: int) -> tuple[int, int]:
    """The number of nodes of points, and of the lowest AABBs, of a tree over n points."""
    n_leaves = -(-n // WIDTH)
    return -(-n_leaves // 2), -(-n_leaves // WIDTH)


def _root(n: int) -> int:
    """The number of the root of a tree over n points, from its first node on."""
    at, n_level = _lowest(n)
    while n_level > 1:
        at, n_level = at + n_level, -(-n_level // WIDTH)
    return at


def write_tree(placed: PlacedCloud, nodes: Any, first: int, stream: Any) -> None:
    """Write the tree of a cloud to nodes from number ``first`` on."""
    n, of_points = len(placed.cloud.points), placed.cloud.points
    points = device.empty(of_points.shape, of_points.dtype, stream)
    points.copy_to_device(of_points, stream=stream)
    keys = sorted_keys(points, stream)
    n_nodes, n_lowest = _lowest(n)
    ball = *placed.T[:3].ravel().tolist(), placed.reach, float(placed.row)
    grid = device.blocks(WIDTH * n_lowest), THREADS, stream
    device.compiled(write_leaves)[grid](points, keys, ball, (first, first + n_nodes), nodes)
    device.compiled(write_levels)[1, _ALONE, stream](first + n_nodes, n_lowest, nodes)


def sorted_keys(points: Any, stream: Any) -> Any:
    """The sorted keys of points on the device, shape (n,) there; ``NUMBER`` of a key is the number of its point."""
    n = len(points)
    keys, spare = (device.empty((n,), np.int64, stream) for _ in range(2))
    extents = device.empty((min(_EXTENTS, device.blocks(n)), 6), np.float64, stream)
    device.compiled(write_extents)[len(extents), THREADS, stream](points, extents)
    device.compiled(write_keys)[device.blocks(n), THREADS, stream](points, extents, keys)
    each = max(_MIN_KEYS, -(-n // _SORTERS))
    blocks = -(-n // (each * _SORTING))
    counts = device.empty((_VALUES * blocks * _SORTING,), np.int32, stream)
    for digit in range(_N_DIGITS):
        shift = NUMBER_BITS + _DIGIT * digit
        device.compiled(count_digits)[blocks, _SORTING, stream](keys, shift, each, counts)
        device.compiled(accumulate)[1, _ALONE, stream](counts)
        device.compiled(move_by_digit)[blocks, _SORTING, stream](keys, shift, each, counts, spare)
        keys, spare = spare, keys
    return keys


def write_extents(points, extents):
    """Write the least and the greatest x, y, z of the points that a block reads, shape (blocks, 6); infinite if it reads none."""
    part = cuda.shared.array((6, THREADS), np.float64)
    thread = cuda.threadIdx.x
    for axis in range(3):
        low, high = np.inf, -np.inf
        for k in range(cuda.grid(1), points.shape[0], cuda.gridsize(1)):
            x = np.float64(points[k, axis])
            low, high = min(low, x), max(high, x)
        part[axis, thread], part[3 + axis, thread] = low, high
    half = cuda.blockDim.x // 2
    while half > 0:
        cuda.syncthreads()
        if thread < half:
            for axis in range(3):
                part[axis, thread] = min(part[axis, thread], part[axis, thread + half])
                part[3 + axis, thread] = max(part[3 + axis, thread], part[3 + axis, thread + half])
        half //= 2
    cuda.syncthreads()
    if thread < 6:
        extents[cuda.blockIdx.x, thread] = part[thread, 0]


def write_keys(points, extents, keys):
    """Write the key of each point: the Morton code of its cell in the cube that holds all points, and its number."""
    bounds = cuda.shared.array(6, np.float64)
    thread, k = cuda.threadIdx.x, cuda.grid(1)
    if thread < 6:
        bound = extents[0, thread]
        for block in range(1, extents.shape[0]):
            bound = min(bound, extents[block, thread]) if thread < 3 else max(bound, extents[block, thread])
        bounds[thread] = bound
    cuda.syncthreads()
    if k < points.shape[0]:
        most, code = (1 << _BITS) - 1, 0
        widest = max(bounds[3] - bounds[0], bounds[4] - bounds[1], bounds[5] - bounds[2])
        scale = most / widest if widest > _NO_EXTENT else 0.0
        for axis in range(3):
            cell = min(int((np.float64(points[k, axis]) - bounds[axis]) * scale), most)
            code |= spread_bits(cell) << (2 - axis)
        keys[k] = code << NUMBER_BITS | k


def count_digits(keys, shift, each, counts):
    """Write how many of the keys of each thread have which digit: the counts of one digit follow each other, thread by thread."""
    own = cuda.shared.array((_VALUES, _SORTING), np.int32)
    thread, sorter, n_sorters = cuda.threadIdx.x, cuda.grid(1), cuda.gridsize(1)
    for value in range(_VALUES):
        own[value, thread] = 0
    for k in range(each * sorter, min(each * (sorter + 1), keys.shape[0])):
        own[keys[k] >> shift & (_VALUES - 1), thread] += 1
    for value in range(_VALUES):
        counts[value * n_sorters + sorter] = own[value, thread]


def accumulate(counts):
    """Replace each count by the sum of those before it. One block does that: each thread for consecutive counts."""
    sums = cuda.shared.array((2, _ALONE), np.int32)
    thread, each = cuda.threadIdx.x, -(-counts.shape[0] // _ALONE)
    first, end = each * thread, min(each * (thread + 1), counts.shape[0])
    total = 0
    for k in range(first, end):
        total += counts[k]
    sums[0, thread] = total
    now, step = 0, 1
    while step < _ALONE:
        cuda.syncthreads()
        before = sums[now, thread - step] if thread >= step else 0
        sums[1 - now, thread] = sums[now, thread] + before
        now, step = 1 - now, 2 * step
    at = sums[now, thread] - total
    for k in range(first, end):
        count = counts[k]
        counts[k] = at
        at += count


def move_by_digit(keys, shift, each, counts, target):
    """Move the keys of each thread to where keys with their digits begin, in their order."""
    own = cuda.shared.array((_VALUES, _SORTING), np.int32)
    thread, sorter, n_sorters = cuda.threadIdx.x, cuda.grid(1), cuda.gridsize(1)
    for value in range(_VALUES):
        own[value, thread] = counts[value * n_sorters + sorter]
    for k in range(each * sorter, min(each * (sorter + 1), keys.shape[0])):
        key = keys[k]
        value = key >> shift & (_VALUES - 1)
        target[own[value, thread]] = key
        own[value, thread] += 1


def write_leaves(points, keys, ball, firsts, nodes):
    """Write the points of each leaf, placed in the base, and its AABB in the lowest nodes of AABBs.

    ball: the upper three rows of T_base_cloud, the radius with the margin for contacts [m], and the row of the ball; firsts: the
    number of the first node of points, and of the first of AABBs.
    """
    leaf, n = cuda.grid(1), keys.shape[0]
    n_leaves, reach = (n + WIDTH - 1) // WIDTH, ball[12]
    above, lane = NODE_ROWS * (firsts[1] + leaf // WIDTH), leaf % WIDTH
    number, second = firsts[0] + leaf // 2, leaf % 2
    if leaf < n_leaves + n_leaves % 2:
        if second == 0:
            for k in range(WIDTH):
                nodes[NODE_ROWS * number + CHILD, k] = 0.0
            nodes[NODE_ROWS * number + CHILD, BALL_ROW], nodes[NODE_ROWS * number + CHILD, BALL_REACH] = ball[13], reach
        for axis in range(3):
            row, low, high = NODE_ROWS * number + 3 * second + axis, NOWHERE, -NOWHERE
            a, b, c, d = ball[4 * axis], ball[4 * axis + 1], ball[4 * axis + 2], ball[4 * axis + 3]
            for k in range(WIDTH):
                x = NOWHERE
                if WIDTH * leaf + k < n:
                    p = keys[WIDTH * leaf + k] & NUMBER
                    x = a * np.float64(points[p, 0]) + b * np.float64(points[p, 1]) + c * np.float64(points[p, 2]) + d
                    low, high = min(low, x), max(high, x)
                nodes[row, k] = x
            if leaf < n_leaves:
                nodes[above + axis, lane], nodes[above + 3 + axis, lane] = low - reach, high + reach
        if leaf < n_leaves:
            nodes[above + CHILD, lane] = float(PLACES * number + FIRST_POINTS + second)
    if n_leaves <= leaf < WIDTH * ((n_leaves + WIDTH - 1) // WIDTH):
        clear_lane(nodes, above, lane)


def write_levels(first, n, nodes):
    """Write the nodes above n nodes from number ``first`` on, up to a root. One block does that."""
    thread = cuda.threadIdx.x
    while n > 1:
        above = first + n
        n_above = (n + WIDTH - 1) // WIDTH
        for k in range(thread, WIDTH * n_above, _ALONE):
            i, lane = NODE_ROWS * (above + k // WIDTH), k % WIDTH
            if k < n:
                write_lane_above(nodes, first + k, i, lane)
            else:
                clear_lane(nodes, i, lane)
        cuda.syncthreads()
        first, n = above, n_above


def join(roots, number, nodes):
    """Write a node over the roots of trees; -1 for a missing one."""
    lane = cuda.threadIdx.x
    if roots[lane] >= 0:
        write_lane_above(nodes, roots[lane] // PLACES, NODE_ROWS * number, lane)
    else:
        clear_lane(nodes, NODE_ROWS * number, lane)
