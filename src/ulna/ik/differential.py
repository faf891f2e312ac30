"""Computes one control step of differential inverse kinematics."""

import threading

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats, positive
from ulna.engine.threads import in_parts
from ulna.errors import InputError
from ulna.ik.entries import differential_ik as entries
from ulna.ik.problem import refuse_immovable
from ulna.kernels.ik.search_layout import N_PER_JOINT, N_SYSTEM, N_TURNED
from ulna.kinematics.jacobian import as_frame
from ulna.kinematics.positions import as_out, as_positions, flat, refuse_out_of_range, rows_of_both
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


_MAX_DAMPING = 1e150


class _Work(threading.local):
    """A thread's own scratch numbers, so that a call allocates none."""

    numbers = np.empty(0)


_work = _Work()


def differential_ik(
    tree: Tree,
    q: ArrayLike,
    twist: ArrayLike,
    dt: float,
    link: str,
    expressed_in: str,
    damping: float,
    out: Array | None,
) -> Array:
    """Joint velocities, shape (..., n_dof); see ``Robot.differential_ik``."""
    refuse_immovable(tree)
    frame, chain = as_frame(expressed_in), tree.chain(link)
    q, twist = as_positions(q, tree), as_floats("twist", twist)
    if twist.shape[-1:] != (6,):
        raise InputError("twist", f"shape {twist.shape}, but shape (..., 6) is expected: v [m/s], w [rad/s]")
    damping, dt = positive("damping", damping), positive("dt", dt)
    if damping > _MAX_DAMPING:
        raise InputError("damping", f"{damping!r}; at most {_MAX_DAMPING:g} is expected, so that its square is finite")
    step = entries.ControlStep(chain, frame, tree.limits, tree.velocity_limits, damping**2, dt)
    if q.ndim == twist.ndim == 1:
        out = as_out(out, q.shape, q, twist)
        size = N_PER_JOINT * tree.n_dof + N_SYSTEM + N_TURNED
        if len(_work.numbers) < size:
            _work.numbers = np.empty(size)
        good = entries.differential_one(step, q, twist, _work.numbers, out)
    else:
        batch, qs, twists = rows_of_both(q, twist, "q", "twist")
        out = as_out(out, (*batch, tree.n_dof), q, twist)
        of_rows = flat(out)

        def run(part: slice) -> bool:
            return entries.differential_batch(step, qs[part], twists[part], of_rows[part])

        good = in_parts(run, len(qs))
    if not good:
        refuse_out_of_range(q)
        refuse_out_of_range(twist, "twist")
    return out
