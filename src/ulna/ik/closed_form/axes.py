"""Finds the axes of the six joints that a closed form turns, in the zero configuration. Used by ``closed_form.families``."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, PARENT, RATIO, REVOLUTE, TABLE_WIDTH
from ulna.kinematics.tree import motion_along_z, row_pose

Array = NDArray[np.float64]
N_AXES = 6


@dataclass(frozen=True, eq=False)
class Axes:
    """Six revolute joints in a row.

    Attributes:
        directions: Unit vectors, shape (6, 3), in the base's axes: q counts turns about them.
        points: A point on each, shape (6, 3) [m].
        end: The pose of the end, shape (4, 4).
        chain: The table of the joints alone, its columns numbered from the base on.
        reach: The length of all parts together [m].
    """

    directions: Array
    points: Array
    end: Array
    chain: Array
    reach: float


def axes_of(chain: Array, columns: tuple[int, ...], q: Array) -> Axes | None:
    """The axes of the joints that six entries of q turn, all others held at q (n_dof,).

    None if one of them turns no joint, several joints, one that slides, or one at a ratio other than 1 and -1.
    """
    T, before, directions, points, rows, order = np.eye(4), np.eye(4), [], [], [], []
    for row in chain:
        kind, column, step = int(row[KIND]), int(row[COLUMN]), row_pose(row)
        if kind == FIXED or column not in columns:
            motion = np.eye(4) if kind == FIXED else motion_along_z(kind, row[RATIO] * q[column] + row[OFFSET])
            T, before = T @ step @ motion, before @ step @ motion
            continue
        if kind != REVOLUTE or abs(row[RATIO]) != 1.0 or column in order:
            return None
        T, before = T @ step, before @ step
        directions.append(row[RATIO] * T[:3, 2])
        points.append(T[:3, 3])
        rows.append([*before[:3].ravel(), REVOLUTE, len(order), row[RATIO], row[OFFSET], len(order) - 1])
        order.append(column)
        T, before = T @ motion_along_z(kind, row[OFFSET]), np.eye(4)
    if len(order) != N_AXES:
        return None
    rows.append([*before[:3].ravel(), FIXED, 0, 1.0, 0.0, N_AXES - 1])
    table = np.array(rows).reshape(-1, TABLE_WIDTH)
    table[:, PARENT] = np.arange(len(table)) - 1
    table.setflags(write=False)
    reach = float(np.linalg.norm(table[1:, [3, 7, 11]], axis=1).sum())
    return Axes(np.array(directions), np.array(points), T, table, reach)


def turning_order(chain: Array) -> tuple[int, ...]:
    """The entries of q that move the chain, in the order in which they first do."""
    moving = [int(row[COLUMN]) for row in chain if int(row[KIND]) != FIXED and row[RATIO] != 0.0]
    return tuple(dict.fromkeys(moving))
