"""Builds the table of a motion's constraints, and bounds how much of a tolerance each edge uses.

The share of a tolerance is the largest deviation on an edge, divided by the tolerance. An edge satisfies a constraint if the
share is at most 1.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.pose import angle_between, inverse
from ulna.errors import InputError, TruthError, UnknownNameError
from ulna.ik.reason import Reason
from ulna.kernels.ik.search_layout import POINTING
from ulna.kernels.layout import BASE, FRAME_WIDTH, PARENT, RATIO
from ulna.kernels.planning.constraint_records import ALL_AXES, MIN_LENGTH, NO_AXIS, TOWARDS, Z_AXIS, Constraint, Constraints
from ulna.kinematics.forward import forward_kinematics
from ulna.kinematics.groups import JointGroup, tip_of
from ulna.kinematics.positions import as_positions, for_kernel, refuse_out_of_range, rows_of_both
from ulna.kinematics.tree import Tree
from ulna.planning.entries import keeping
from ulna.planning.keep import AIM, Keep

Array = NDArray[np.float64]
_CHORD = 2.5  # [rad^2/m or rad]: squared edge length per unit of tolerance; longer chords usually violate the constraint
_PRECISION = 1e-3  # precision of a share of a tolerance
_PARALLEL = 1e-9  # a smaller cosine counts as 0
_TOLERANCE_SHRINK = 0.998  # factor of a search's tolerances, so that any part of its path can be certified again


def freeze(keeps: Constraints) -> Constraints:
    """Make the arrays of constraints read-only, as entries require; unpickled arrays are writable."""
    keeps.frames.setflags(write=False)
    keeps.allowed.setflags(write=False)
    return keeps


class Violation(NamedTuple):
    """The violation of a constraint in one component.

    Attributes:
        link: The link.
        quantity: "x", "y" or "z" for the displacement in the axes of the constraint [m], or "angle" [rad].
        value: The deviation.
        tolerance: The tolerance of the deviation.
        relative_to: The reference link; None for the base.
    """

    link: str
    quantity: str
    value: float
    tolerance: float
    relative_to: str | None = None

    def __str__(self) -> str:
        name = self.link if self.relative_to is None else f"{self.link} relative to {self.relative_to}"
        if self.quantity == "angle":
            return f"{name} is rotated by {self.value:.4g} rad; {self.tolerance:.4g} rad is allowed"
        return f"{name} is off by {self.value * 1e3:.4g} mm along {self.quantity}; {self.tolerance * 1e3:.4g} mm is allowed"


@dataclass(frozen=True, eq=False)
class KeepReport:
    """Whether edges satisfy constraints. ``bool(report)`` is allowed for one edge: ``if robot.edge_keeps(...)``.

    Attributes:
        kept: Whether the whole edge certainly satisfies them: a bool for one edge, else shape (...,).
        violation: An upper bound of the largest share of its tolerance that any constraint uses on the edge: a float for one
            edge, else shape (...,). The bound is at most 0.001 too large; above 1 at most by 0.1 %.
    """

    kept: Any
    violation: Any

    def __bool__(self) -> bool:
        if np.ndim(self.kept):
            raise TruthError("a KeepReport", "report.kept")
        return bool(self.kept)


def as_keeps(
    keep: Keep | Iterable[Keep], tree: Tree, q_start: Array, link: str | None = None, group: JointGroup | None = None
) -> tuple[Keep, ...]:
    """Check the constraints of a motion from q_start, shape (n_dof,), and give each its link, pose and axis.

    link: the default link of a constraint; for None the tip of the group, or the robot's tip.

    Raises:
        InputError: An element is not a ``Keep``, or no joint moves its link, or moves it relative to the reference link. Two
            constraints of a link contradict each other. Or there are several tips and no link is named.
        UnknownNameError: There is no such link.
    """
    if not isinstance(keep, (Keep, Iterable)) or isinstance(keep, (str, bytes, dict)):
        raise InputError("keep", f"{type(keep).__name__}; an ulna.Keep, or several, is expected")
    keeps = []
    for one in (keep,) if isinstance(keep, Keep) else keep:
        if not isinstance(one, Keep):
            raise InputError("keep", f"{type(one).__name__}; an ulna.Keep, or several, is expected")
        name = link if one.link is None else one.link
        if name is None and group is not None:
            name = tip_of(group)
        name = tree.link_or_tip(name)
        _, between = _joints_of_both(tree, name, one.relative_to)
        if not (tree.joints[between, RATIO] != 0.0).any():
            beside = "" if one.relative_to is None else f" relative to {one.relative_to!r}"
            raise InputError("keep", f"no joint moves link {name!r}{beside}")
        keeps.append(one.at_start(_relative_pose(tree, q_start, name, one.relative_to), name))
    for a, b in combinations(keeps, 2):
        if (a.link, a.relative_to, a.towards, b.towards) == (b.link, b.relative_to, False, False):
            _refuse_contradiction(a, b)
    return tuple(keeps)


def _relative_pose(tree: Tree, q: Array, link: str, relative_to: str | None) -> Array:
    """The pose of a link relative to the base or to another link, shape (4, 4)."""
    T = forward_kinematics(tree, q, link)
    return T if relative_to is None else inverse(forward_kinematics(tree, q, relative_to)) @ T


def _joints_of_both(tree: Tree, link: str, relative_to: str | None) -> tuple[int, list[int]]:
    """The last joint that carries both links, or BASE, and the joints that carry only one of them."""
    rows: list[set[int]] = []
    for name in (link, tree.root if relative_to is None else relative_to):
        if name not in tree.link_row:
            raise UnknownNameError("link", str(name), tree.link_names)
        rows.append(set())
        row = tree.link_row[name]
        while row != BASE:
            rows[-1].add(row)
            row = int(tree.joints[row, PARENT])
    return max(rows[0] & rows[1], default=BASE), sorted(rows[0] ^ rows[1])


def _refuse_contradiction(a: Keep, b: Keep) -> None:
    """Raise an error if boxes or angles of two constraints of one link do not overlap."""
    (R_a, r_a), (R_b, r_b) = ((keep.pose[:3, :3] @ keep.task.frame[:3, :3], np.array(keep.task.slack)) for keep in (a, b))
    between, cosines = b.pose[:3, 3] - a.pose[:3, 3], np.abs(R_a.T @ R_b)
    cosines[cosines < _PARALLEL] = 0.0
    for R, r, cosine, other in ((R_a, r_a, cosines, r_b), (R_b, r_b, cosines.T, r_a)):
        reach = r[:3] + (cosine * np.where(cosine > 0.0, other[:3], 0.0)).sum(axis=1)
        beyond = float((np.abs(R.T @ between) - reach).max())
        if beyond > 0.0:
            raise InputError("keep", f"two constraints of {a.link!r} contradict each other: they are {beyond:.3g} m apart")
    if (a.keeps_axis, a.task.axis) == (b.keeps_axis, b.task.axis):
        turn = R_a.T @ R_b
        angle = float(np.arccos(np.clip(turn[2, 2], -1.0, 1.0))) if a.keeps_axis else float(angle_between(a.pose, b.pose))
        if angle > r_a[3] + r_b[3]:
            raise InputError("keep", f"two constraints of {a.link!r} contradict each other: they are {angle:.3g} rad apart")


def make_constraint_table(keeps: tuple[Keep, ...], tree: Tree) -> Constraints | None:
    """The table of constraints that the kernels read; None without constraints."""
    if not keeps:
        return None
    frames, allowed = np.zeros((2 * len(keeps), FRAME_WIDTH)), Constraint.records(len(keeps))
    for i, keep in enumerate(keeps):
        frames[2 * i] = tree.frame_row(str(keep.link), keep.task.frame)
        frames[2 * i + 1] = tree.frame_row(
            tree.root if keep.relative_to is None else keep.relative_to, keep.pose @ keep.task.frame
        )
        _write_allowed(keep, float(np.linalg.norm(frames[2 * i, [3, 7, 11]])), allowed[i])
        allowed[i].shared = _joints_of_both(tree, str(keep.link), keep.relative_to)[0]
    return freeze(Constraints(frames, allowed))


def _write_allowed(keep: Keep, lever: float, allowed: Constraint) -> None:
    """Write the tolerances of a constraint. lever: the distance of its frame's origin from the joint's [m]."""
    slack, turn, allowed.lever = np.array(keep.task.slack), keep.task.slack[3], lever
    allowed.away[:], allowed.slack[:], allowed.is_pointing = slack[:3], AIM * slack, keep.task.kind == POINTING
    if turn < np.inf:
        compared = TOWARDS if keep.towards else Z_AXIS
        allowed.axes = compared if keep.keeps_axis else ALL_AXES
        allowed.chord = 2.0 * np.sin(0.5 * turn) * (1.0 if keep.keeps_axis else np.sqrt(2.0))


def shrink_tolerances(keeps: Constraints | None) -> Constraints | None:
    """A copy of the constraints with slightly smaller tolerances."""
    if keeps is None:
        return None
    allowed = keeps.allowed.copy()
    allowed["away"] *= _TOLERANCE_SHRINK
    allowed["chord"] *= _TOLERANCE_SHRINK
    return freeze(keeps._replace(allowed=allowed))


def max_step(keeps: Constraints | None) -> float:
    """The length of a search's step along constraints, eight chords; infinite without constraints."""
    return np.inf if keeps is None else float(8 * np.sqrt(_CHORD * min_tolerance(keeps)))


def min_tolerance(keeps: Constraints) -> float:
    """The smallest tolerance of the constraints [m or rad]."""
    chords = np.where(keeps.allowed["axes"] != NO_AXIS, keeps.allowed["chord"], np.inf)
    return float(min(chords.min(), keeps.allowed["away"].min()))


def satisfy_constraints(table: Constraints | None, tree: Tree, a: Array, b: Array) -> NDArray[np.bool_]:
    """Mask of the edges from a to b, shape (n, n_dof) each, that certainly satisfy all constraints."""
    if table is None:
        return np.ones(len(a), dtype=bool)
    return _edge_shares(table, tree, a.copy(), b.copy(), 1.0, keeping.APART, 1.0) <= 1.0


def worst_violation(table: Constraints | None, tree: Tree, path: Array) -> float:
    """An upper bound of the share of a tolerance that a path, shape (n, n_dof), uses; 0 without constraints."""
    return 0.0 if table is None else float(tolerance_shares(table, tree, path).max())


def tolerance_shares(table: Constraints, tree: Tree, path: Array) -> Array:
    """An upper bound of the share of a tolerance that each edge of a path, shape (n, n_dof), uses."""
    a, b = (path[:-1], path[1:]) if len(path) > 1 else (path, path)
    return _edge_shares(table, tree, a.copy(), b.copy(), 0.0, _PRECISION, np.inf)


def edge_keeps(tree: Tree, q_a: ArrayLike, q_b: ArrayLike, keep: Keep | Iterable[Keep]) -> KeepReport:
    """See ``Robot.edge_keeps``."""
    starts, ends = as_positions(q_a, tree, "q_a"), as_positions(q_b, tree, "q_b")
    refuse_out_of_range(starts, "q_a")
    refuse_out_of_range(ends, "q_b")
    one = starts.ndim == ends.ndim == 1
    batch, a, b = ((), starts[None], ends[None]) if one else rows_of_both(starts, ends, "q_a", "q_b")
    if not len(a):
        return KeepReport(np.empty(batch, dtype=bool), np.empty(batch))
    table = make_constraint_table(as_keeps(keep, tree, a[0]), tree)
    if table is None:
        raise InputError("keep", "no constraint is given")
    kept = satisfy_constraints(table, tree, a, b).reshape(batch)
    violation = _edge_shares(table, tree, a, b, 0.0, _PRECISION, np.inf).reshape(batch)
    return KeepReport(bool(kept), float(violation)) if one else KeepReport(kept, violation)


def violations(keeps: tuple[Keep, ...], tree: Tree, q: Array) -> Reason:
    """The violations of constraints at q, shape (n_dof,), in words; the data is a tuple of ``Violation``."""
    found = [one for keep in keeps for one in _violations_of(keep, tree, q)]
    return Reason("; ".join(map(str, found)), tuple(found))


def _violations_of(keep: Keep, tree: Tree, q: Array) -> list[Violation]:
    frame, link = keep.task.frame, str(keep.link)
    T, reference, slack = _relative_pose(tree, q, link, keep.relative_to) @ frame, keep.pose @ frame, keep.task.slack
    away = np.abs(inverse(reference) @ T)[:3, 3].tolist()
    angle = float(angle_between(T, reference))
    if keep.keeps_axis:
        there = reference[:3, 2]
        if keep.towards:
            there = reference[:3, 3] - T[:3, 3]
            there = there / max(float(np.linalg.norm(there)), MIN_LENGTH)
        angle = 2.0 * float(np.arcsin(min(1.0, np.linalg.norm(T[:3, 2] - there) / 2.0)))
    values = zip(("x", "y", "z", "angle"), (*away, angle), slack[:4], strict=True)
    return [
        Violation(link, name, value, most, keep.relative_to)
        for name, value, most in values
        if value > most * _TOLERANCE_SHRINK * (1.0 - 2.0 * keeping.APART)
    ]


def _edge_shares(table: Constraints, tree: Tree, a: Array, b: Array, level: float, apart: float, most: float) -> Array:
    """An upper bound of the share of a tolerance that each edge uses, shape (n,); see ``planning.entries.keeping``."""
    shares = np.zeros(len(a))
    keeping.shares_of_edges(tree.joints, freeze(table), for_kernel(a), for_kernel(b), keeping.Bound(level, apart, most), shares)
    return shares
