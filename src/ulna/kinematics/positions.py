"""Joint positions at the public edge: what every function that takes q makes of it."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError
from ulna.kernels.layout import LARGEST
from ulna.model.arrays import as_floats
from ulna.model.tree import Tree

_NO_LIMIT = 1e3  # descriptions write 1e16 where they mean none; samples scattered over that would be of no use


def as_positions(q: ArrayLike, tree: Tree, name: str = "q") -> NDArray[np.float64]:
    """q as a C-contiguous float64 array of shape (..., n_dof); an ``InputError`` if it has another shape."""
    q = as_floats(name, q)
    if q.shape[-1:] != tree.q_shape:
        raise InputError(name, f"shape {q.shape}, but shape (..., {tree.n_dof}) is expected: {_joints(tree)}")
    return q


def refuse_out_of_range(q: NDArray[np.float64], name: str = "q") -> None:
    """Raise an ``InputError`` if q holds NaN, infinity or a number too large to compute with."""
    faults = np.argwhere(~(np.abs(q) <= LARGEST))
    if not len(faults):
        return
    bad = faults[0]
    index = ", ".join(str(int(k)) for k in bad)
    value = q[tuple(bad)]
    reason = "not a finite number" if not np.isfinite(value) else f"beyond {LARGEST:g}, where angles lose their digits"
    raise InputError(f"{name}[{index}]", f"{value} is {reason}")


def flat(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """The batch as one axis, shape (n, n_dof)."""
    return q.reshape(int(np.prod(q.shape[:-1])), q.shape[-1])


def for_kernel(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """q with at least one entry, which a kernel of a robot without joints does not read."""
    return q if q.shape[-1] else np.zeros((*q.shape[:-1], 1))


def range_to_sample(lower: ArrayLike, upper: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where random configurations are drawn from, of limits of shape (n_dof,).

    Where a limit is infinite, or as good as, they lie within a turn of the other limit, or within pi of zero.
    """
    lower, upper = (np.where(np.abs(side) > _NO_LIMIT, np.copysign(np.inf, side), side) for side in (lower, upper))
    low = np.where(np.isinf(lower), np.where(np.isinf(upper), -np.pi, np.subtract(upper, 2 * np.pi)), lower)
    return low, np.where(np.isinf(upper), low + 2 * np.pi, upper)


def _joints(tree: Tree) -> str:
    if not tree.joint_names:
        return "the robot has no moving joints"
    shown = ", ".join(tree.joint_names[:8])
    return f"one entry for each of {shown}" + (" ..." if len(tree.joint_names) > 8 else "")
