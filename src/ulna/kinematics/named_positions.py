"""Turns names of joints with their positions, as a ``JointState`` of ROS has them, into q. Used by ``Robot``."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError
from ulna.kinematics.positions import as_positions, refuse_out_of_range
from ulna.kinematics.tree import Tree


def q_of_joints(names: Sequence[str], positions: ArrayLike, others: ArrayLike | None, tree: Tree) -> NDArray[np.float64]:
    """q, shape (n_dof,), of the named joints of a tree; see ``Robot.q_of_joints``.

    Raises:
        InputError: The names and the positions do not go together, or joints are missing.
    """
    values = as_floats("positions", positions)
    if values.shape != (len(names),):
        raise InputError("positions", f"shape {values.shape}, but one position for each of {len(names)} names is expected")
    refuse_out_of_range(values, "positions")
    given = dict(zip(names, values.tolist(), strict=True))
    if len(given) < len(names):
        raise InputError("names", f"{next(name for name in names if list(names).count(name) > 1)!r} is named twice")
    slices = dict(zip(tree.joint_names, tree.joint_slices, strict=True))
    if others is None:
        missing = [name for name in slices if name not in given]
        if missing:
            raise InputError("names", f"the joints {', '.join(missing)} are missing; others=q says where they are")
        others = np.zeros(tree.n_dof)
    q = np.array(as_positions(others, tree, "others"))
    if q.ndim != 1:
        raise InputError("others", f"shape {q.shape}, but one configuration is expected")
    for name in slices.keys() & given.keys():
        if slices[name].stop - slices[name].start != 1:
            raise InputError("names", f"{name!r} has several positions; others=q says where it is")
        q[slices[name]] = given[name]
    return q
