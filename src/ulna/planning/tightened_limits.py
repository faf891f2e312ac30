"""Narrows the limits of a robot, by numbers, by names of joints, or by a file ``joint_limits.yaml``."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.structure import Drive
from ulna.errors import DescriptionWarning, InputError, UnknownNameError
from ulna.kinematics.tree import Narrowed, Tree, entry_names
from ulna.planning.motion_limits import GivenLimits, limits_of

Array = NDArray[np.float64]
Given = ArrayLike | Mapping[str, ArrayLike]
_DIGITS = 1e-4  # relative, or [rad or m]: a limit wider by less was rounded to fewer digits
_POSITIONS = "lower", "upper"


def narrow_limits(tree: Tree, limits: GivenLimits | None, given: Mapping[str, Given | None]) -> Narrowed:
    """The limits of a tree, narrowed by a file and by given values.

    given: ``lower``, ``upper``, ``velocity``, ``acceleration`` and ``jerk``, as for ``Robot.with_limits``.

    Raises:
        InputError: A limit is wider than the robot's or invalid, or a joint would have no range.
        UnknownNameError: There is no such joint.
        FileError, DescriptionError: See ``limits_of``.
    """
    n, names = tree.n_dof, entry_names(tree)
    kept = tree.narrowed or Narrowed(np.full(n, -np.inf), *(np.full(n, np.inf) for _ in range(4)))
    rates = {"velocity": tree.velocity_limits, "acceleration": tree.acceleration_limits, "jerk": tree.jerk_limits}
    narrowed = {"lower": tree.lower, "upper": tree.upper, **rates}
    of_file = {} if limits is None else _read_file(limits, tree, names)
    stated = _read_given(tree, names, given)
    for argument, each in (("limits", of_file), ("", stated)):
        for quantity, values in each.items():
            narrowed[quantity] = _narrow(argument or quantity, quantity, values, narrowed[quantity], names)
    lower, upper = narrowed["lower"], narrowed["upper"]
    empty = np.flatnonzero(~(lower < upper) & (tree.lower < tree.upper))
    if len(empty):
        k = int(empty[0])
        argument = next((name for name in _POSITIONS if name in stated), "limits")
        range_ = f"{lower[k]:.6g} to {upper[k]:.6g}"
        raise InputError(argument, f"{names[k]} would have the range {range_}, which is empty; held= holds a joint")
    for name, own in rates.items():
        unchanged = ~(narrowed[name] < own) & (own > 0.0)
        narrowed[name] = np.where(unchanged, getattr(kept, name), narrowed[name])
    return Narrowed(**narrowed)


def _read_file(limits: GivenLimits, tree: Tree, names: tuple[str, ...]) -> dict[str, Array]:
    """Read the limits of a file or its mapping; NaN for limits that it does not have."""
    if isinstance(limits, str) and Path(limits).suffix not in {".yaml", ".yml"}:
        raise InputError("limits", f"{limits!r}; a file joint_limits.yaml, or the mapping of one, is expected")
    arm = limits_of(limits, names, tree.followers, ())
    if arm.scaling != (1.0, 1.0):
        warnings.warn(
            f"{arm.source}: its default scaling factors are not limits, and are ignored here; "
            "trajectory(limits=...) applies them",
            DescriptionWarning,
            stacklevel=4,
        )
    stated = {"velocity": arm.velocity, "acceleration": arm.acceleration, "jerk": arm.jerk}
    for name, values in (("lower", arm.lower), ("upper", arm.upper)):
        stated[name] = None if values is None else np.where(np.isinf(values), np.nan, values)
    return {name: values for name, values in stated.items() if values is not None}


def _read_given(tree: Tree, names: tuple[str, ...], given: Mapping[str, Given | None]) -> dict[str, Array]:
    """The given limits of each quantity, shape (n_dof,); NaN where none is given."""
    stated: dict[str, Array] = {}

    def note(quantity: str, columns: slice | int, values: Array) -> None:
        known = stated.setdefault(quantity, np.full(tree.n_dof, np.nan))
        tighter = np.fmax if quantity == "lower" else np.fmin
        known[columns] = tighter(known[columns], values)

    slices = dict(zip(tree.joint_names, tree.joint_slices, strict=True)) | {name: slice(k, k + 1) for k, name in enumerate(names)}
    for quantity, value in given.items():
        if value is None:
            continue
        by_name = value if isinstance(value, Mapping) else {"": value}
        for name, each in by_name.items():
            follower = tree.followers.get(name)
            if name and name not in slices and follower is None:
                raise UnknownNameError("joint", str(name), (*tree.joint_names, *tree.followers))
            columns = slices.get(name, slice(None)) if follower is None else slice(follower.column, None)
            n = 1 if follower is not None else len(range(tree.n_dof)[columns])
            values = _as_values(f"{quantity}[{name!r}]" if name else quantity, each, quantity, n)
            if follower is None:
                note(quantity, columns, values)
            else:
                note(*_to_leader_limit(quantity, follower, float(values[0])))
    return stated


def _to_leader_limit(quantity: str, follower: Drive, value: float) -> tuple[str, int, Array]:
    """Convert the limit of a mimic joint to a limit of its leader: quantity, entry of q and value."""
    if follower.column is None:
        raise AssertionError("only followers that an entry of q moves are kept")
    if quantity not in _POSITIONS:
        return quantity, follower.column, np.array(value / abs(follower.ratio))
    if follower.ratio < 0.0:
        quantity = _POSITIONS[1 - _POSITIONS.index(quantity)]
    return quantity, follower.column, np.array((value - follower.offset) / follower.ratio)


def _as_values(argument: str, given: ArrayLike, quantity: str, n: int) -> Array:
    """Check the limit of n entries of q, one number or n numbers, and return n numbers."""
    values = as_floats(argument, given)
    if values.shape not in {(), (n,)} or np.isnan(values).any():
        raise InputError(argument, f"{given!r}; a number{f', or {n} of them,' if n > 1 else ''} is expected")
    if quantity not in _POSITIONS and not (values > 0.0).all():
        raise InputError(argument, f"{given!r}; {'numbers' if n > 1 else 'a number'} above 0 is expected")
    return np.full(n, values)


def _narrow(argument: str, quantity: str, stated: Array, own: Array, names: tuple[str, ...]) -> Array:
    """Narrow the limits of a quantity. The robot's limit 0 of a rate, as some exporters write, is no limit."""
    towards = -1.0 if quantity == "lower" else 1.0
    most = towards * np.where((own == 0.0) & (quantity not in _POSITIONS), np.inf, own)
    with np.errstate(invalid="ignore"):  # the difference of two infinite limits
        wider = np.where(np.isnan(stated) | (stated == own), 0.0, towards * stated - most)
    over = np.flatnonzero(wider > _DIGITS * np.maximum(1.0, np.abs(own)))
    if len(over):
        k = int(over[0])
        wide = f"{wider[k]:.4g} wider than its own of {own[k]:.6g}"
        raise InputError(
            argument, f"{stated[k]:.6g} is the {quantity} limit of {names[k]}, {wide}; limits can only be narrowed"
        )  # fmt: skip
    return towards * np.fmin(towards * stated, most)
