"""Holds a Denavit-Hartenberg table, and formats it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import pi

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import matrix_from_rpy, rpy_from_matrix
from ulna.description.robot_description import Limits, Mimic, frozen
from ulna.errors import InputError, did_you_mean
from ulna.notebook import tables

Array = NDArray[np.float64]
# Axes within this angle [rad] are parallel. A file with six decimals is off by half of that, and the common normal of such axes
# would lie hundreds of kilometers away.
PARALLEL = 1e-6
CONVENTIONS = ("modified", "standard")
_HEADERS = "", "joint", "a [m]", "d [m]", "alpha [rad]", "theta [rad]"
ROW_PRODUCTS = {"modified": "Rx(alpha) Tx(a) Tz(d) Rz(theta)", "standard": "Rz(theta) Tz(d) Tx(a) Rx(alpha)"}


def checked_convention(convention: str) -> str:
    """The convention; an ``InputError`` for an unknown name."""
    if convention not in CONVENTIONS:
        raise InputError("convention", f"{convention!r} is not known{did_you_mean(str(convention), CONVENTIONS)}")
    return convention


def constant_poses(row: Array, convention: str) -> tuple[Array, Array]:
    """The constant poses before and after Rz(q) or Tz(q) in one row's transform."""
    a, d, alpha, theta = row
    T_z, T_x = np.eye(4), np.eye(4)
    T_z[2, 3], T_x[0, 3] = d, a
    T_z[:3, :3], T_x[:3, :3] = matrix_from_rpy((0, 0, theta)), matrix_from_rpy((alpha, 0, 0))
    return (T_x @ T_z, np.eye(4)) if convention == "modified" else (T_z, T_x)


@dataclass(frozen=True, eq=False)
class DHTable:
    """The Denavit-Hartenberg table of a serial arm: T_base_tip = T_base_0 T_0_1(q) ... T_n-1_n(q) T_n_tip.

    ``str(table)`` is a table to copy; ``ulna.Robot.from_dh(table)`` is its robot.
    """

    name: str
    """The robot's name."""
    convention: str
    """``"modified"`` (Craig) or ``"standard"``."""
    base: str
    tip: str
    """The first and the last link of the table."""
    rows: Array
    """a [m], d [m], alpha [rad], theta_offset [rad], shape (n, 4): one row for each moving joint of the chain."""
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    """``"revolute"``, ``"continuous"`` or ``"prismatic"``, one a row. z points along the joint's positive direction: no signs."""
    limits: tuple[Limits, ...]
    mimics: tuple[Mimic | None, ...]
    """For a row whose joint mimics that of another row: the leader, the multiplier and the offset."""
    T_base_0: Array
    """The pose of frame 0 in the base, shape (4, 4)."""
    T_n_tip: Array
    """The pose of the tip in frame n, shape (4, 4)."""
    max_position_difference: float
    """The proof: the maximum distance [m] between the table's and the robot's tip, over ``n_configurations`` random ones."""
    max_rotation_difference: float
    """The maximum angle [rad] between them."""
    n_configurations: int
    notes: tuple[str, ...] = ()
    """Decisions about axes that are nearly parallel."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", frozen(self.rows, (-1, 4)))
        for key in ("T_base_0", "T_n_tip"):
            object.__setattr__(self, key, frozen(getattr(self, key), (4, 4)))

    def __reduce__(self):
        return type(self), tuple(getattr(self, field.name) for field in fields(self))

    def __str__(self) -> str:
        return "\n".join(_lines(self))

    def __repr__(self) -> str:
        n = len(self.rows)
        worst = f"off by at most {self.max_position_difference:.2g} m, {self.max_rotation_difference:.2g} rad"
        rows = f"{n} row{'s' * (n != 1)}, {self.convention}"
        return f"<DHTable of {self.name!r}: {rows}, {self.base} to {self.tip}, {worst}>"

    def _repr_html_(self) -> str:
        title, product, *_ = _lines(self)
        return tables.table(f"{title}; {product}", _HEADERS, _cells(self), _notes(self))


def _lines(table: DHTable) -> Iterator[str]:
    yield f"{table.name}: {table.convention} DH table from {table.base} to {table.tip}"
    yield f"a row is {ROW_PRODUCTS[table.convention]}"
    yield ""
    yield from _aligned([_HEADERS, *_cells(table)])
    yield ""
    yield from _notes(table)


def _cells(table: DHTable) -> Iterator[tuple[str, ...]]:
    """The number, the joint, a, d, alpha and theta of each row."""
    for k, (name, kind, row) in enumerate(zip(table.joint_names, table.joint_types, table.rows, strict=True), start=1):
        yield (str(k), name, *row_words(k, kind, row))


def _notes(table: DHTable) -> Iterator[str]:
    """The lines below the rows: mimics, the first frame and the tip, and the proof."""
    for k, mimic in enumerate(table.mimics, start=1):
        if mimic is not None:
            yield mimic_words(k, table.joint_names.index(mimic.joint) + 1, mimic.multiplier, mimic.offset)
    yield f"frame 0 in {table.base}: {pose_words(table.T_base_0)}"
    yield f"{table.tip} in frame {len(table.rows)}: {pose_words(table.T_n_tip)}"
    yield from table.notes
    yield proof_words(table.max_position_difference, table.max_rotation_difference, table.n_configurations)


def proof_words(position: float, rotation: float, n: int) -> str:
    """The proof as a sentence."""
    return f"largest difference at {n} random configurations: {position:.2g} m, {rotation:.2g} rad"


def mimic_words(k: int, leader: int, multiplier: float, offset: float) -> str:
    """The mimic relation of row k, as an equation."""
    return f"q{k} = {multiplier:.9g} * q{leader} + {offset:.9g}"


def row_words(k: int, kind: str, row: Sequence[float] | Array) -> tuple[str, str, str, str]:
    """a, d, alpha and theta of row k, with q in its place."""
    a, d, alpha, theta = length_words(row[0]), length_words(row[1]), angle_words(row[2]), angle_words(row[3])
    return (a, _with_q(k, d), alpha, theta) if kind == "prismatic" else (a, d, alpha, _with_q(k, theta))


def _with_q(k: int, constant: str) -> str:
    sign = " - " if constant.startswith("-") else " + "
    return f"q{k}" if constant == "0" else f"q{k}{sign}{constant.removeprefix('-')}"


def length_words(value: float) -> str:
    """A length with nine digits."""
    return f"{value + 0.0:.9g}"


def angle_words(value: float) -> str:
    """An angle, as a fraction of pi if it equals one to the last digits."""
    for divisor in (1, 2, 3, 4, 6, 12):
        parts = value * divisor / pi
        if round(parts) and abs(parts - round(parts)) < 1e-13:
            factor = {1: "", -1: "-"}.get(round(parts), str(round(parts)))
            return f"{factor}pi" + (f"/{divisor}" if divisor > 1 else "")
    return length_words(value)


def pose_words(T: Array) -> str:
    """A pose as position and roll, pitch, yaw."""
    if np.array_equal(T, np.eye(4)):
        return "the identity"
    xyz = ", ".join(length_words(value) for value in T[:3, 3])
    rpy = ", ".join(angle_words(value) for value in rpy_from_matrix(T))
    return f"xyz = ({xyz}) m, rpy = ({rpy}) rad"


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Align the columns: names to the left, numbers to the right."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        cells = [
            cell.ljust(width) if k == 1 else cell.rjust(width) for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  ".join(cells).rstrip()
