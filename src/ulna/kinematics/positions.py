"""Validates q, ``out=`` and names of joints, reshapes q for the kernels, and builds q from named joints."""

from collections.abc import Iterable, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.likely_units import TWO_TURNS, degrees_in_words, warn_of_unit
from ulna.errors import InputError, UnknownNameError, count_of
from ulna.kernels.layout import LARGEST
from ulna.kinematics.tree import Tree, entry_names
from ulna.kinematics.turns import turning_columns

_MAX_DEGREES = 3600.0  # a larger number is another mistake, which has its own error
NO_Q = -1
"""n_dof of a robot without joints, for the low-latency entries. No q has this length, so every q takes the validating path."""
FLOAT64 = np.dtype(np.float64)


def as_positions(q: ArrayLike, tree: Tree, name: str = "q") -> NDArray[np.float64]:
    """q as a C-contiguous float64 array of shape (..., n_dof)."""
    if type(q) is np.ndarray and q.dtype is FLOAT64 and q.shape[-1:] == tree.q_shape:
        return q if q.flags.carray else q.copy()  # the most frequent cases, without another call
    floats = as_floats(name, q)
    if floats.shape[-1:] != tree.q_shape:
        raise InputError(name, f"shape {floats.shape}, but shape (..., {tree.n_dof}) is expected: {_joints(tree)}")
    if not isinstance(q, np.ndarray):
        look_for_degrees(floats, tree, name)
    return floats


def look_for_degrees(q: NDArray[np.float64], tree: Tree, name: str) -> None:
    """Warn of angles that are probably degrees: beyond two turns, and beyond the limits of a joint that has limits.

    A list of numbers is looked at, as a person types it. An array may be large, and its check would take longer than a pose.

    Args:
        q: Joint positions [rad or m], shape (..., n_dof).
        tree: The robot's joints.
        name: The name of the argument.

    Warns:
        UnitWarning: An angle is probably in degrees.
    """
    if not TWO_TURNS < np.abs(q).max(initial=0.0) <= _MAX_DEGREES:
        return
    rows = flat(q)
    is_angle = turning_columns(tree.joints, tree.n_dof) & np.isfinite(tree.lower) & np.isfinite(tree.upper)
    beyond = is_angle & ((rows < tree.lower) | (rows > tree.upper)).any(axis=0)
    hint = degrees_in_words(rows[:, beyond])
    if hint:
        column = int(np.argmax(np.where(beyond, np.abs(rows).max(axis=0), 0.0)))
        warn_of_unit(name, f"{entry_names(tree)[column]} is at {np.abs(rows[:, column]).max():g}{hint}")


def as_configuration(q: ArrayLike, tree: Tree, name: str) -> NDArray[np.float64]:
    """One configuration, shape (n_dof,), which may violate the limits."""
    one = as_positions(q, tree, name)
    if one.ndim != 1:
        raise InputError(name, f"shape {one.shape}; one configuration, shape ({tree.n_dof},), is expected")
    refuse_out_of_range(one, name)
    return one


def refuse_out_of_range(q: NDArray[np.float64], name: str = "q") -> None:
    """Raise an error for a q with NaN, infinity or a number too large to compute with."""
    in_range = np.abs(q) <= LARGEST
    if in_range.all():
        return
    bad = np.argwhere(~in_range)[0]
    index = ", ".join(str(int(k)) for k in bad)
    value = q[tuple(bad)]
    reason = "not a finite number" if not np.isfinite(value) else f"beyond {LARGEST:g}, where angles lose their digits"
    raise InputError(f"{name}[{index}]", f"{value} is {reason}")


def is_within(q: NDArray[np.float64], tree: Tree) -> bool:
    """Whether every entry of q, shape (..., n_dof), is within the limits, and small enough to compute with."""
    return bool(((tree.lower_finite <= q) & (q <= tree.upper_finite)).all())


def flat(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """The batch as one axis, shape (n, n_dof); a view."""
    if q.ndim == 1:
        return q[None]  # in half the time of the other cases
    return q if q.ndim == 2 else q.reshape(prod(q.shape[:-1]), q.shape[-1])


def rows_of_both(a: NDArray, b: NDArray, name_a: str, name_b: str) -> tuple[tuple[int, ...], NDArray, NDArray]:
    """The common batch shape of two batches, and the rows of each (``rows_of``)."""
    try:
        batch = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
    except ValueError:
        raise InputError(name_b, f"shape {b.shape} does not go with {name_a} of shape {a.shape}") from None
    return batch, rows_of(a, batch), rows_of(b, batch)


def rows_of(a: NDArray, batch: tuple[int, ...]) -> NDArray[np.float64]:
    """A C-contiguous copy with one row for each element of a batch, shape (n, ...).

    Raises a ``ValueError`` if it does not broadcast to the batch shape.
    """
    return flat(np.array(np.broadcast_to(a, (*batch, a.shape[-1])), order="C"))


def for_kernel(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """q with at least one entry, which the kernels of a robot without joints ignore."""
    return q if q.shape[-1] else np.zeros((*q.shape[:-1], 1))


def _joints(tree: Tree) -> str:
    if not tree.joint_names:
        return "the robot has no moving joints"
    shown = ", ".join(tree.joint_names[:8])
    return f"one entry for each of {shown}" + (" ..." if len(tree.joint_names) > 8 else "")


def q_of_joints(names: Sequence[str], positions: ArrayLike, others: ArrayLike | None, tree: Tree) -> NDArray[np.float64]:
    """q, shape (n_dof,), from named joints of a tree; see ``Robot.q_of_joints``."""
    values = as_floats("positions", positions)
    if values.shape != (len(names),):
        raise InputError(
            "positions", f"shape {values.shape}, but one position for each of {count_of(len(names), 'name')} is expected"
        )
    refuse_out_of_range(values, "positions")
    given = dict(zip(names, values.tolist(), strict=True))
    if len(given) < len(names):
        raise InputError("names", f"{next(name for name in names if list(names).count(name) > 1)!r} is named twice")
    slices = dict(zip(tree.joint_names, tree.joint_slices, strict=True))
    if others is None:
        missing = [name for name in slices if name not in given]
        if missing:
            raise InputError("names", f"the joints {', '.join(missing)} are missing; give them with others=q")
        others = np.zeros(tree.n_dof)
    q = np.array(as_positions(others, tree, "others"))
    if q.ndim != 1:
        raise InputError("others", f"shape {q.shape}, but one configuration is expected")
    for name in slices.keys() & given.keys():
        if slices[name].stop - slices[name].start != 1:
            raise InputError("names", f"{name!r} has several positions; others=q says where it is")
        q[slices[name]] = given[name]
    return q


def as_names(names: Iterable[str], argument: str = "held", kind: str = "joints") -> tuple[str, ...]:
    """The names in an argument, one or several: by default joints to hold."""
    try:
        return (names,) if isinstance(names, str) else tuple(names)
    except TypeError:
        raise InputError(argument, f"{names!r}; names of {kind} are expected") from None


def columns_of_joints(tree: Tree, names: Iterable[str]) -> NDArray[np.bool_]:
    """Mask of the entries of q that belong to these joints, shape (n_dof,)."""
    columns = np.zeros(tree.n_dof, dtype=bool)
    for name in names:
        if name not in tree.joint_names:
            raise UnknownNameError("joint", str(name), tree.joint_names)
        columns[tree.joint_slices[tree.joint_names.index(name)]] = True
    return columns


def as_out(out: NDArray[Any] | None, shape: tuple[int, ...], *inputs: NDArray[Any], dtype: type = np.float64) -> NDArray[Any]:
    """The array for a result: ``out`` if it is given and fits, else a new one.

    Args:
        out: The caller's array, or None.
        shape: The shape of the result.
        inputs: The arrays from which the result is computed; they must not share memory with ``out``.
        dtype: The type of the result.

    Example:
        >>> as_out(None, (2, 3)).shape
        (2, 3)
    """
    if out is None:
        return np.empty(shape, dtype)
    if type(out) is not np.ndarray:
        raise InputError("out", f"{type(out).__name__}; a NumPy array is expected")
    if out.shape != shape or out.dtype != dtype or not out.dtype.isnative:
        raise InputError("out", f"{out.dtype} of shape {out.shape}; {np.dtype(dtype)} of shape {shape} is expected")
    if not out.flags.carray:
        raise InputError("out", "a writable, aligned, C-contiguous array is expected; numpy.empty(shape) makes one")
    if any(_share(out, given) for given in inputs):
        raise InputError("out", "shares memory with what the result is computed from; give another array")
    return out


def _share(a: NDArray[Any], b: NDArray[Any]) -> bool:
    """Whether two arrays may share memory. Arrays that own theirs do not, and this test is three times faster."""
    return a is b or (not (a.flags.owndata and b.flags.owndata) and np.may_share_memory(a, b))
