"""Denavit-Hartenberg tables in, description out."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError, did_you_mean
from ulna.kernels.layout import LARGEST
from ulna.model.arrays import as_floats
from ulna.model.description import Description, Joint, JointType, Limits, Link
from ulna.model.pose import pose

_Z = (0.0, 0.0, 1.0)
_TYPES = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC, JointType.FIXED)


def description_from_dh(
    rows: ArrayLike,
    *,
    convention: str = "modified",
    joint_types: Sequence[str] | None = None,
    limits: ArrayLike | None = None,
    name: str = "robot",
) -> Description:
    """The description of the serial arm in a DH table.

    Args:
        rows: One row a joint: a [m], d [m], alpha [rad], theta_offset [rad]; shape (n, 4).
        convention: ``"modified"`` (Craig): a row is Rx(alpha) Tx(a) Tz(d) Rz(theta); ``"standard"``: Rz(theta) Tz(d) Tx(a)
            Rx(alpha).
        joint_types: ``"revolute"`` (unless said), ``"continuous"``, ``"prismatic"`` (moves d) or ``"fixed"``, one a row.
        limits: Lower and upper limit of each moving joint [rad or m], shape (n_moving, 2); none unless given.
        name: The robot's name.

    Returns:
        Links ``base``, ``link1`` ... ``linkN``, the DH frames, and joints ``joint1`` ... ``jointN``.
    """
    table = _table(rows)
    types = _joint_types(joint_types, len(table))
    if convention not in ("modified", "standard"):
        raise InputError("convention", f"{convention!r} is not known{did_you_mean(str(convention), ('modified', 'standard'))}")
    bounds = _bounds(limits, types)
    links, joints = [Link("base")], []
    for k, (row, kind) in enumerate(zip(table, types, strict=True), start=1):
        parent, child = links[-1].name, f"link{k}"
        before, behind = _around_the_motion(row, convention)
        if kind == JointType.FIXED:
            before, behind = before @ behind, np.eye(4)
        carrier = child if np.array_equal(behind, np.eye(4)) else f"link{k}_carrier"
        joints.append(
            Joint(f"joint{k}", kind, parent, carrier, before, np.array(_Z), next(bounds) if kind != JointType.FIXED else Limits())
        )
        links.append(Link(carrier))
        if carrier != child:
            joints.append(Joint(f"joint{k}_offset", JointType.FIXED, carrier, child, behind, np.array(_Z)))
            links.append(Link(child))
    return Description(name, tuple(links), tuple(joints), source="DH table")


def _around_the_motion(row: NDArray, convention: str) -> tuple[NDArray, NDArray]:
    """The constant poses before and behind Rz(q) or Tz(q) in one row's transform."""
    a, d, alpha, theta = row
    along_z = pose((0, 0, d), (0, 0, theta))
    along_x = pose((a, 0, 0), (alpha, 0, 0))
    return (along_x @ along_z, np.eye(4)) if convention == "modified" else (along_z, along_x)


def _table(rows: ArrayLike) -> NDArray[np.float64]:
    table = as_floats("rows", rows)
    if table.ndim != 2 or table.shape[1] != 4 or len(table) == 0:
        raise InputError("rows", f"shape {table.shape}, but (n, 4) is expected: a, d, alpha, theta_offset")
    if not np.isfinite(table).all():
        raise InputError("rows", "has an entry that is not finite")
    if np.abs(table).max() > LARGEST:
        raise InputError("rows", f"has an entry beyond {LARGEST:g}")
    return table


def _joint_types(joint_types: Sequence[str] | None, n: int) -> list[JointType]:
    try:
        names = ["revolute"] * n if joint_types is None else list(joint_types)
    except TypeError:
        raise InputError("joint_types", f"{joint_types!r} is not a list of joint types") from None
    if len(names) != n:
        raise InputError("joint_types", f"{len(names)} for {n} rows")
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
        raise InputError(
            "limits", f"shape {table.shape}; {n_moving} pairs of lower <= upper are expected, one for each moving joint"
        )
    return iter([Limits(float(lower), float(upper)) for lower, upper in table])
