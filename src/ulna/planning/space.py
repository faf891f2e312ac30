"""Describes the configuration space of a plan: limits, metric, and joints without limits."""

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
_ROUNDING = 1e-12  # [rad or m]: positions that differ by at most this are equal


@dataclass(frozen=True, eq=False)
class Space:
    """The configuration space of a plan.

    Attributes:
        table: The kernels' record for each entry of q (limits, period, weight), shape (n_dof,).
        moving: Mask of the entries of q that the plan may change, shape (n_dof,).
    """

    table: Records[Entry]
    moving: NDArray[np.bool_]

    @cached_property
    def n_moving(self) -> int:
        """The number of entries of q that the plan may change."""
        return int(np.count_nonzero(self.moving))

    @property
    def radians(self) -> Array:
        """The change of each entry of q that counts as one radian, shape (n_dof,); 0 for entries that are fixed."""
        return np.where(self.moving, 1.0 / self.table["weight"], 0.0)

    @cached_property
    def diameter(self) -> float:
        """The largest distance between two configurations."""
        extent = np.where(self.table["period"] > 0, 0.5 * self.table["period"], self.table["high"] - self.table["low"])
        return float(np.linalg.norm(extent * self.table["weight"]))

    def shortest_way(self, q: Array) -> Array:
        """Differences of configurations, shape (..., n_dof), without whole turns of joints without limits."""
        period = self.table["period"]
        return np.where(period > 0, q - period * np.rint(q / np.where(period > 0, period, 1.0)), q)

    def with_bound(self, bound: float, start: Array, goals: Array) -> "Space":
        """The part of the space that contains all paths shorter than a bound from a start to a goal.

        Each path lies in an ellipsoid with foci at the start and the goal (Gammell, Srinivasa and Barfoot, Informed RRT*, IROS
        2014). The limits become the ellipsoids' bounding box; joints without limits do not change.
        """
        way = self.shortest_way(goals - start) * self.table["weight"]
        extent = 0.5 * np.sqrt(np.maximum(bound**2 - (way**2).sum(axis=1, keepdims=True) + way**2, 0.0))
        center, extent = start + 0.5 * way / self.table["weight"], extent / self.table["weight"]
        table, turning = self.table.copy(), self.table["period"] > 0
        table["low"] = np.where(turning, table["low"], np.maximum(table["low"], (center - extent).min(axis=0)))
        table["high"] = np.where(turning, table["high"], np.minimum(table["high"], (center + extent).max(axis=0)))
        return Space(table, self.moving)

    def hold(self, columns: NDArray[np.int64], q: Array) -> "Space":
        """The space with more entries of q held, at the values of a configuration."""
        table, moving = self.table.copy(), self.moving.copy()
        table["low"][columns] = table["high"][columns] = q[columns]
        moving[columns] = False
        return Space(table, moving)

    def lengths(self, differences: Array) -> Array:
        """The weighted lengths of differences of configurations, shape (...,)."""
        return np.linalg.norm(differences * self.table["weight"], axis=-1)


def make_space(tree: Tree, corners: Array, fixed: NDArray[np.bool_], far: float = 0.0) -> Space:
    """The space of a robot for a search between a start and goals, ``corners``, shape (n, n_dof).

    Its range is the joint limits, extended to the corners if they lie outside. For a slide without a limit, the range extends
    beyond the corners by the robot's length plus the objects' distance ``far`` [m].

    An angle has weight 1. A slide is weighted so that it moves the robot as far as an average angle. A rotation by one radian
    moves the farthest frame that the joint carries by at most the frame's distance along the chain.
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
    """Mask of the entries of q, shape (..., n_dof), equal to the start's up to rounding and whole turns."""
    return np.abs(_whole_space(tree).space.shortest_way(q - start)) <= _ROUNDING


def endless_entries(tree: Tree) -> NDArray[np.bool_]:
    """Mask of the entries of q that are angles without limits, shape (n_dof,)."""
    return _whole_space(tree).space.table["period"] > 0


def has_endless_slide(tree: Tree) -> bool:
    """Whether a slide lacks a limit on one side or both, so that ``make_space`` needs the objects' distance."""
    return _whole_space(tree).endless


class _WholeSpace(NamedTuple):
    """The space of a robot before it is extended to a start and goals.

    Attributes:
        space: The space, with the joint limits as its range.
        below: Mask of the slides without a lower limit, shape (n_dof,).
        above: Mask of the slides without an upper limit, shape (n_dof,).
        length: The robot's length [m].
        endless: Whether a slide lacks a limit.
        least: A start and goals from ``least`` to ``most`` need no wider space; an empty range if a slide lacks a limit.
        most: See ``least``.
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
    """Compute the whole space of a robot; cached, since it loops over joints in Python."""
    table, endless = Entry.records(tree.n_dof), np.isinf(tree.lower) & np.isinf(tree.upper)
    slides, length = _slide_mask(tree), length_of_robot(tree)
    table["low"], table["high"] = random_range(tree)
    table["period"] = np.where(endless & turning_columns(tree.joints, tree.n_dof), TURN, 0.0)
    table["weight"] = np.where(slides, 1.0 / (_mean_lever(tree, ~slides) or length), 1.0)
    below, above = (slides & (np.abs(limits) > LARGEST) for limits in (tree.lower, tree.upper))
    without_end, turning = bool(below.any() or above.any()), table["period"] > 0
    least, most = np.where(turning, -np.inf, table["low"]), np.where(turning, np.inf, table["high"])
    space = Space(table, np.ones(tree.n_dof, dtype=bool))
    least = np.full(tree.n_dof, np.inf) if without_end else least
    return _WholeSpace(space, below, above, length, without_end, least, most)


def sample_line(a: Array, b: Array, apart: float) -> Array:
    """Samples of the line from a (excluded) to b (included), at most ``apart`` apart in each entry of q."""
    n = max(1, int(np.ceil(np.abs(b - a).max() / apart)))
    return a + np.linspace(0.0, 1.0, n + 1)[1:, None] * (b - a)


def _mean_lever(tree: Tree, turns: NDArray[np.bool_]) -> float:
    """The mean lever [m] of the revolute joints: the distance along the chain to the farthest frame that each carries.

    Each lever is weighted by itself, so that many short fingers do not outweigh an arm. It is 0 without angles. turns: mask of
    the entries that are angles.
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


def _slide_mask(tree: Tree) -> NDArray[np.bool_]:
    """Mask of the entries of q that drive only slides, shape (n_dof,)."""
    slides, turns = np.zeros(tree.n_dof, dtype=bool), np.zeros(tree.n_dof, dtype=bool)
    for kind, column in zip(tree.joints[:, KIND], tree.joints[:, COLUMN].astype(np.int64), strict=True):
        if kind != FIXED:
            (slides if kind == PRISMATIC else turns)[column] = True
    return slides & ~turns
