"""Finds the axes of a closed form's joints, in the zero configuration."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, PARENT, PRISMATIC, RATIO, REVOLUTE, TABLE_WIDTH
from ulna.kinematics.size import length_of, size_of
from ulna.kinematics.tree import motion_along_z, row_pose

Array = NDArray[np.float64]
N_AXES = 6
_SAME_AXIS = 1e-12  # sine of an angle, or share of the reach


class Coupling(NamedTuple):
    """A joint driven by its own entry of q plus a multiple of another, like Fanuc's J3 with J2."""

    column: int
    """The entry of the joint."""
    leader: int
    """The other entry."""
    ratio: int
    """The multiple, an integer."""


@dataclass(frozen=True, eq=False)
class Axes:
    """The axes of a serial chain: n of an arm, or six, some of them possibly added.

    Attributes:
        directions: Unit vectors, shape (n, 3), in the base's axes: q counts rotations about them, or meters along them.
        points: A point on each axis, shape (n, 3) [m].
        slides: Mask of the prismatic joints, shape (n,).
        entries: The entry that each joint reads, shape (n,), numbered from the base on.
        end: The pose of the end, shape (4, 4).
        chain: The table of these joints alone, with entries numbered in the same way.
        reach: The sum of all lengths [m].
        slide: The longest stroke of the prismatic joints [m].
    """

    directions: Array
    points: Array
    slides: NDArray[np.bool_]
    entries: NDArray[np.int64]
    end: Array
    chain: Array
    reach: float
    slide: float

    @property
    def unit(self) -> float:
        """The length to which length tolerances are relative [m]: the reach, or the longest stroke if the reach is negligible."""
        return size_of(self.reach, self.slide)


def decoupled(chain: Array) -> tuple[Array, tuple[Coupling, ...]]:
    """Split a chain into one without couplings, and the couplings.

    A coupling is a follower joint that rotates about the axis of its neighbor.
    """
    moving = [i for i, row in enumerate(chain) if int(row[KIND]) != FIXED and row[RATIO] != 0.0]
    columns = [int(chain[i][COLUMN]) for i in moving]
    changed, couplings, reach = chain.copy(), [], length_of(chain[1:])
    for i, column in zip(moving, columns, strict=True):
        place = moving.index(i)
        neighbors = [moving[k] for k in (place - 1, place + 1) if 0 <= k < len(moving)]
        possible = [one for j in neighbors if columns.count(column) > 1 and (one := _coupling(chain, i, j, reach)) is not None]
        if possible and columns.count(possible[0].column) == 1:
            at_zero = row_pose(chain[i]) @ motion_along_z(REVOLUTE, chain[i][OFFSET])
            changed[i, :PARENT] = [*at_zero[:3].ravel(), FIXED, 0, 1.0, 0.0]
            couplings.append(possible[0])
    changed.setflags(write=False)
    return (changed, tuple(couplings)) if couplings else (chain, ())


def _coupling(chain: Array, i: int, j: int, reach: float) -> Coupling | None:
    """The coupling of joint row j to the entry of follower row i, if both rotate about one axis."""
    follower, joint = chain[i], chain[j]
    if int(follower[KIND]) != REVOLUTE or int(joint[KIND]) != REVOLUTE or follower[COLUMN] == joint[COLUMN]:
        return None
    first, last = min(i, j), max(i, j)
    pose = motion_along_z(REVOLUTE, chain[first][OFFSET])
    for row in chain[first + 1 : last]:
        pose = pose @ row_pose(row) @ (np.eye(4) if int(row[KIND]) == FIXED else motion_along_z(int(row[KIND]), row[OFFSET]))
    other_axis = (pose @ row_pose(chain[last]))[:3, 2:]  # the other axis and a point on it, in the frame of the first joint
    is_coaxial = (np.linalg.norm(other_axis[:2], axis=0) <= _SAME_AXIS * np.array([1.0, reach])).all()
    ratio = np.sign(other_axis[2, 0]) * follower[RATIO] / joint[RATIO]
    if not is_coaxial or abs(joint[RATIO]) != 1.0 or ratio != np.rint(ratio):
        return None
    return Coupling(int(joint[COLUMN]), int(follower[COLUMN]), int(ratio))


def axes_of(chain: Array, columns: tuple[int, ...], q: Array, slide: float) -> Axes | None:
    """The axes of the joints that some entries of q move, with all others held at q (n_dof,).

    slide: As in ``Axes``. None if one of the entries moves no joint, several joints, or one at a ratio other than 1 and -1.
    """
    pose, before, directions, points, rows, order = np.eye(4), np.eye(4), [], [], [], []
    for row in chain:
        kind, column, step = int(row[KIND]), int(row[COLUMN]), row_pose(row)
        if kind == FIXED or column not in columns:
            motion = np.eye(4) if kind == FIXED else motion_along_z(kind, row[RATIO] * q[column] + row[OFFSET])
            pose, before = pose @ step @ motion, before @ step @ motion
            continue
        if abs(row[RATIO]) != 1.0 or column in order:
            return None
        pose, before = pose @ step, before @ step
        directions.append(row[RATIO] * pose[:3, 2])
        points.append(pose[:3, 3])
        rows.append([*before[:3].ravel(), kind, len(order), row[RATIO], row[OFFSET]])
        order.append(column)
        pose, before = pose @ motion_along_z(kind, row[OFFSET]), np.eye(4)
    if len(order) != len(columns):
        return None
    rows.append([*before[:3].ravel(), FIXED, 0, 1.0, 0.0])
    table = table_of_rows(rows)
    slides = table[:-1, KIND] == PRISMATIC
    reach = length_of(table[1:])
    return Axes(np.array(directions), np.array(points), slides, np.arange(len(order)), pose, table, reach, slide)


def normal_to(h: Array) -> Array:
    """A unit vector perpendicular to h."""
    n: Array = np.cross(h, np.eye(3)[np.argmin(np.abs(h))]).astype(np.float64)
    return n / float(np.linalg.norm(n))


def frame_along(h: Array) -> Array:
    """A rotation (3, 3) with the unit vector h as its z axis.

    Its columns are a normal n, h x n and h.
    """
    n = normal_to(h)
    return np.column_stack([n, np.cross(h, n), h])


def nearest_point(directions: Array, points: Array) -> tuple[Array, float]:
    """The point nearest to lines that are not all parallel, and its maximum distance from them."""
    projections = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    point = np.linalg.solve(projections.sum(axis=0), np.einsum("nij,nj->i", projections, points))
    return point, float(np.linalg.norm(np.einsum("nij,nj->ni", projections, point - points), axis=1).max())


def table_of_rows(rows: list) -> Array:
    """A chain from rows without PARENT, which is the row above."""
    table = np.empty((len(rows), TABLE_WIDTH))
    table[:, :PARENT], table[:, PARENT] = rows, np.arange(len(rows)) - 1
    table.setflags(write=False)
    return table


def turning_order(chain: Array) -> tuple[int, ...]:
    """The entries of q that move the chain, in the order of their first joints."""
    moving = [int(row[COLUMN]) for row in chain if int(row[KIND]) != FIXED and row[RATIO] != 0.0]
    return tuple(dict.fromkeys(moving))
