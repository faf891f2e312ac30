"""Lists the solids of a tree by their numbers, and gives each as a row of a table (``kernels.collision.collision_layout``)."""

import numpy as np
from numpy.typing import NDArray

from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import (
    BALL_ROW,
    CHILD,
    CHILDREN,
    FIRST_BALL,
    FIRST_POINTS,
    NO_NODE,
    NODE_ROWS,
    PLACES,
)

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_PRESENT = 1e299  # [m]: a point at or beyond it is missing


def numbers_below(nodes: Array, root: int) -> Numbers:
    """The numbers of the solids in a tree, shape (n,)."""
    found, below = [np.empty(0, np.int64)], np.array([root] if root != NO_NODE else [], dtype=np.int64)
    while len(below):
        number, kind = below // PLACES, below % PLACES
        of_points = kind != CHILDREN
        found.append(_balls_in(nodes, number[of_points], kind[of_points] - FIRST_POINTS))
        children = nodes.reshape(-1, NODE_ROWS, WIDTH)[number[~of_points], CHILD].ravel()
        children = children[~np.isnan(children)].astype(np.int64)
        found.append(-1 - children[children < 0])
        below = children[children >= 0]
    return np.concatenate(found)


def rows_of(nodes: Array, numbers: Numbers) -> Numbers:
    """The row of the table that says the size, the object and the touch set of each solid, shape (n,)."""
    rows, is_ball = numbers.copy(), numbers >= FIRST_BALL
    number = (numbers[is_ball] - FIRST_BALL) // (2 * WIDTH)
    rows[is_ball] = nodes.reshape(-1, NODE_ROWS, WIDTH)[number, CHILD, BALL_ROW]
    return rows


def table_of(table: Array, nodes: Array, numbers: Numbers) -> Array:
    """Solids as rows of a table of their own, shape (n, BODY_WIDTH)."""
    solids, is_ball = table[rows_of(nodes, numbers)], numbers >= FIRST_BALL
    number, place = np.divmod(numbers[is_ball] - FIRST_BALL, 2 * WIDTH)
    second, lane = np.divmod(place, WIDTH)
    for axis in range(3):
        solids[is_ball, 3 + 4 * axis] = nodes[NODE_ROWS * number + 3 * second + axis, lane]
    return solids


def _balls_in(nodes: Array, number: Numbers, second: Numbers) -> Numbers:
    """The numbers of the balls in the first or the second half of nodes of points."""
    lanes = np.arange(WIDTH)
    present = nodes[NODE_ROWS * number + 3 * second] < _PRESENT
    return (FIRST_BALL + (2 * WIDTH * number + WIDTH * second)[:, None] + lanes)[present]
