"""Describes the configurations that a plan may use: limits, metric, joints that turn for ever."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Records
from ulna.kernels.layout import BASE, COLUMN, FIXED, KIND, LARGEST, PARENT, PRISMATIC, RATIO
from ulna.kernels.planning.constraint_records import Entry
from ulna.kinematics.sample import length_of_robot, random_range
from ulna.kinematics.tree import Tree
from ulna.kinematics.turns import TURN, turning_columns

Array = NDArray[np.float64]
_ROUNDING = 1e-12  # [rad or m]: positions that differ by no more are the same


@dataclass(frozen=True, eq=False)
class Space:
    """The configurations of a plan.

    Attributes:
        table: What the kernels read of each entry of q, shape (n_dof,).
        moving: Which entries of q the plan may change, shape (n_dof,).
    """

    table: Records[Entry]
    moving: NDArray[np.bool_]

    @cached_property
    def n_moving(self) -> int:
        """How many entries of q the plan may change."""
        return int(np.count_nonzero(self.moving))

    @property
    def radians(self) -> Array:
        """The weight of each entry of q in radians, 0 for one that the plan may not change, shape (n_dof,)."""
        return np.where(self.moving, 1.0 / self.table["weight"], 0.0)

    @cached_property
    def diameter(self) -> float:
        """The greatest distance of two configurations."""
        extent = np.where(self.table["period"] > 0, 0.5 * self.table["period"], self.table["high"] - self.table["low"])
        return float(np.linalg.norm(extent * self.table["weight"]))

    def shortest_way(self, q: Array) -> Array:
        """Differences of configurations, shape (..., n_dof), less whole turns of the joints that may turn for ever."""
        period = self.table["period"]
        return np.where(period > 0, q - period * np.rint(q / np.where(period > 0, period, 1.0)), q)

    def within(self, bound: float, start: Array, goals: Array) -> "Space":
        """The space with limits that hold all paths from a start to one of the goals that are shorter than a bound.

        Such a path lies in an ellipsoid with these two as its foci (Gammell, Srinivasa and Barfoot, Informed RRT*, IROS 2014);
        the limits are those of its box. The joints that turn for ever keep theirs.
        """
        way = self.shortest_way(goals - start) * self.table["weight"]
        extent = 0.5 * np.sqrt(np.maximum(bound**2 - (way**2).sum(axis=1, keepdims=True) + way**2, 0.0))
        centre, extent = start + 0.5 * way / self.table["weight"], extent / self.table["weight"]
        table, turning = self.table.copy(), self.table["period"] > 0
        table["low"] = np.where(turning, table["low"], np.maximum(table["low"], (centre - extent).min(axis=0)))
        table["high"] = np.where(turning, table["high"], np.minimum(table["high"], (centre + extent).max(axis=0)))
        return Space(table, self.moving)

    def holding(self, columns: NDArray[np.int64], q: Array) -> "Space":
        """The space with more entries of q held, at those of a configuration."""
        table, moving = self.table.copy(), self.moving.copy()
        table["low"][columns] = table["high"][columns] = q[columns]
        moving[columns] = False
        return Space(table, moving)

    def lengths(self, differences: Array) -> Array:
        """The lengths of differences of configurations, shape (...,)."""
        return np.linalg.norm(differences * self.table["weight"], axis=-1)


def make_space(tree: Tree, corners: Array, fixed: NDArray[np.bool_], far: float = 0.0) -> Space:
    """The space of a robot; samples are taken from the limits, and as far as start and goals, shape (n, n_dof), lie.

    Of a slide without a limit they are taken from beside them, as far as the robot is long and the objects reach, ``far`` [m].

    An angle has weight 1. A slide has the weight with which it moves the robot as far as an angle does, in a mean over the joints
    that turn: a radian of one moves the farthest frame that it carries by at most their distance along the chain.
    """
    whole = _whole_space(tree)
    if not fixed.any() and ((whole.least <= corners) & (corners <= whole.most)).all():
        return whole.space  # the most frequent case
    table, turning = whole.space.table.copy(), whole.space.table["period"] > 0
    if whole.endless:
        beside = whole.length + far
        table["low"] = np.where(whole.below, np.maximum(tree.lower, corners.min(axis=0) - beside), table["low"])
        table["high"] = np.where(whole.above, np.minimum(tree.upper, corners.max(axis=0) + beside), table["high"])
    table["low"] = np.where(turning, table["low"], np.minimum(table["low"], corners.min(axis=0)))
    table["high"] = np.where(turning, table["high"], np.maximum(table["high"], corners.max(axis=0)))
    table["low"][fixed] = table["high"][fixed] = corners[0, fixed]
    return Space(table, ~fixed)


def same_entries(tree: Tree, start: Array, q: Array) -> NDArray[np.bool_]:
    """Which entries of q, shape (..., n_dof), are those of a start, but for rounding and whole turns of endless joints."""
    return np.abs(_whole_space(tree).space.shortest_way(q - start)) <= _ROUNDING


def endless_entries(tree: Tree) -> NDArray[np.bool_]:
    """Which entries of q may turn for ever, shape (n_dof,)."""
    return _whole_space(tree).space.table["period"] > 0


def slides_without_end(tree: Tree) -> bool:
    """Whether a slide has no limit to one side or both, so that ``make_space`` asks how far objects are."""
    return _whole_space(tree).endless


class _WholeSpace(NamedTuple):
    """The space of a robot without a start and goals, its slides without a limit, and its length [m].

    And where a start and goals leave it as it is: from ``least`` to ``most``; nowhere if there is a slide without a limit.
    """

    space: Space
    below: NDArray[np.bool_]
    above: NDArray[np.bool_]
    length: float
    endless: bool
    least: Array
    most: Array


@lru_cache(maxsize=16)
def _whole_space(tree: Tree) -> _WholeSpace:
    """Kept, since it is looked up in Python, joint by joint."""
    table, endless = Entry.records(tree.n_dof), np.isinf(tree.lower) & np.isinf(tree.upper)
    slides, length = _slides(tree), length_of_robot(tree)
    table["low"], table["high"] = random_range(tree)
    table["period"] = np.where(endless & turning_columns(tree.joints, tree.n_dof), TURN, 0.0)
    table["weight"] = np.where(slides, 1.0 / (_mean_lever(tree, ~slides) or length), 1.0)
    below, above = (slides & (np.abs(limits) > LARGEST) for limits in (tree.lower, tree.upper))
    without_end, turning = bool(below.any() or above.any()), table["period"] > 0
    least, most = np.where(turning, -np.inf, table["low"]), np.where(turning, np.inf, table["high"])
    space = Space(table, np.ones(tree.n_dof, dtype=bool))
    least = np.full(tree.n_dof, np.inf) if without_end else least
    return _WholeSpace(space, below, above, length, without_end, least, most)


def along(a: Array, b: Array, apart: float) -> Array:
    """Configurations on the straight line from a to b, b among them and not a, at most ``apart`` apart in each entry of q."""
    n = max(1, int(np.ceil(np.abs(b - a).max() / apart)))
    return a + np.linspace(0.0, 1.0, n + 1)[1:, None] * (b - a)


def _mean_lever(tree: Tree, turns: NDArray[np.bool_]) -> float:
    """The mean over turning joints of the distance to the farthest frame that each carries, along the chain [m].

    Each counts by its own distance: many short fingers do not outweigh an arm. 0 without any. turns: which entries are angles.
    """
    far, levers = np.zeros(len(tree.joints)), np.zeros(tree.n_dof)
    for link, T in tree.link_offset.items():
        if tree.link_row[link] != BASE:
            far[tree.link_row[link]] = max(far[tree.link_row[link]], np.linalg.norm(T[:3, 3]))
    for k in range(len(far) - 1, -1, -1):
        parent, column = int(tree.joints[k, PARENT]), int(tree.joints[k, COLUMN])
        if parent != BASE:
            far[parent] = max(far[parent], far[k] + np.linalg.norm(tree.joints[k, 3:12:4]))
        levers[column] = max(levers[column], abs(tree.joints[k, RATIO]) * far[k])
    levers = levers[turns]
    return float(levers @ levers / levers.sum()) if levers.any() else 0.0


def _slides(tree: Tree) -> NDArray[np.bool_]:
    """Which entries of q drive slides alone."""
    slides, turns = np.zeros(tree.n_dof, dtype=bool), np.zeros(tree.n_dof, dtype=bool)
    for kind, column in zip(tree.joints[:, KIND], tree.joints[:, COLUMN].astype(np.int64), strict=True):
        if kind != FIXED:
            (slides if kind == PRISMATIC else turns)[column] = True
    return slides & ~turns
