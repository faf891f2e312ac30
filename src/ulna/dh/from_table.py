"""Converts a Denavit-Hartenberg table to a description."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.likely_units import check_description, check_dh_rows
from ulna.description.pose import as_one_pose
from ulna.description.robot_description import Description, Joint, JointType, Limits, Link, Mimic
from ulna.dh.table import DHTable, checked_convention, constant_poses
from ulna.errors import InputError, count_of, did_you_mean
from ulna.kernels.layout import LARGEST

_Z = (0.0, 0.0, 1.0)
_TYPES = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC, JointType.FIXED)


def description_from_dh(
    rows: ArrayLike,
    *,
    convention: str = "modified",
    joint_types: Sequence[str] | None = None,
    limits: ArrayLike | None = None,
    T_base_0: ArrayLike | None = None,
    T_n_tip: ArrayLike | None = None,
    name: str = "robot",
) -> Description:
    """The description of the serial arm in a DH table.

    Returns:
        Links ``base``, ``link1`` ... ``linkN``, the DH frames, and joints ``joint1`` ... ``jointN``. With ``T_base_0`` there is a
        ``link0`` after ``base``, with ``T_n_tip`` a ``tip`` after ``linkN``.
    """
    table = _table(rows)
    types = _joint_types(joint_types, len(table))
    bounds = _bounds(limits, types)
    joints = [
        _Row(f"joint{k}", kind, next(bounds) if kind != JointType.FIXED else Limits()) for k, kind in enumerate(types, start=1)
    ]
    ends = [T if T is None else as_one_pose(T, key) for key, T in (("T_base_0", T_base_0), ("T_n_tip", T_n_tip))]
    description = _serial_arm(name, table, checked_convention(convention), joints, *ends)
    check_dh_rows(table)
    check_description("rows", description)
    return description


def description_of_table(table: DHTable) -> Description:
    """The description of the arm in a table from ``Robot.dh``. Its joints keep their names, limits and mimics."""
    joints = [
        _Row(name, JointType(kind), limits, mimic)
        for name, kind, limits, mimic in zip(table.joint_names, table.joint_types, table.limits, table.mimics, strict=True)
    ]
    return _serial_arm(table.name, table.rows, table.convention, joints, table.T_base_0, table.T_n_tip)


class _Row(NamedTuple):
    """The joint of a row, without the row's four numbers."""

    name: str
    type: JointType
    limits: Limits
    mimic: Mimic | None = None


def _serial_arm(
    name: str, table: NDArray, convention: str, rows: Sequence[_Row], T_base_0: NDArray | None, T_n_tip: NDArray | None
) -> Description:
    chain = _Chain({row.name for row in rows})
    if T_base_0 is not None:
        chain.fix("base_to_link0", "link0", T_base_0)
    for k, (numbers, row) in enumerate(zip(table, rows, strict=True), start=1):
        child = f"link{k}"
        pose_before, pose_after = constant_poses(numbers, convention)
        if row.type == JointType.FIXED:
            chain.add(row, child, pose_before @ pose_after)
        elif np.array_equal(pose_after, np.eye(4)):
            chain.add(row, child, pose_before)
        else:
            chain.add(row, f"{child}_carrier", pose_before)
            chain.fix(f"{row.name}_offset", child, pose_after)
    if T_n_tip is not None:
        chain.fix(f"{chain.links[-1].name}_to_tip", "tip", T_n_tip)
    return Description(name, tuple(chain.links), tuple(chain.joints), source="DH table")


class _Chain:
    """A growing list of links and joints; names of fixed joints avoid those of the rows."""

    def __init__(self, used_names: set[str]) -> None:
        self.links, self.joints, self.used_names = [Link("base")], [], used_names

    def add(self, row: _Row, child: str, T_parent_joint: NDArray) -> None:
        parent = self.links[-1].name
        joint = Joint(row.name, row.type, parent, child, T_parent_joint, np.array(_Z), row.limits, row.mimic)
        self.joints.append(joint)
        self.links.append(Link(child))

    def fix(self, name: str, child: str, T_parent_child: NDArray) -> None:
        while name in self.used_names:
            name += "_"
        self.add(_Row(name, JointType.FIXED, Limits()), child, T_parent_child)


def _table(rows: ArrayLike) -> NDArray[np.float64]:
    table = as_floats("rows", rows)
    if table.ndim != 2 or table.shape[1] != 4:
        raise InputError("rows", f"shape {table.shape}, but (n, 4) is expected: a, d, alpha, theta_offset")
    if not np.isfinite(table).all():
        raise InputError("rows", "has an entry that is not finite")
    if np.abs(table).max(initial=0.0) > LARGEST:
        raise InputError("rows", f"has an entry beyond {LARGEST:g}")
    return table


def _joint_types(joint_types: Sequence[str] | None, n: int) -> list[JointType]:
    try:
        names = ["revolute"] * n if joint_types is None else list(joint_types)
    except TypeError:
        raise InputError("joint_types", f"{joint_types!r} is not a list of joint types") from None
    if len(names) != n:
        raise InputError("joint_types", f"{len(names)} for {count_of(n, 'row')}")
    for name in names:
        if name not in list(_TYPES):
            raise InputError("joint_types", f"{name!r} is not known in a DH table{did_you_mean(str(name), list(_TYPES))}")
    return [JointType(name) for name in names]


def _bounds(limits: ArrayLike | None, types: list[JointType]):
    n_moving = sum(kind != JointType.FIXED for kind in types)
    if limits is None:
        return iter([Limits()] * n_moving)
    table = as_floats("limits", limits)
    if (
        table.shape != (n_moving, 2)
        or not ((table[:, 0] <= table[:, 1]) & (table[:, 0] < np.inf) & (table[:, 1] > -np.inf)).all()
    ):
        pairs, are = count_of(n_moving, "pair"), "is" if n_moving == 1 else "are"
        raise InputError("limits", f"shape {table.shape}; {pairs} of lower <= upper {are} expected, one for each moving joint")
    return iter([Limits(float(lower), float(upper)) for lower, upper in table])
