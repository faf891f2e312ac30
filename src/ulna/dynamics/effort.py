"""Checks given torque limits, and computes the payload within them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError
from ulna.kinematics.tree import Tree, entry_names

Array = NDArray[np.float64]
_MIN_TORQUE = 1e-11  # [Nm or N]: a smaller torque due to 1 kg is rounding


def as_effort_limits(torque: ArrayLike, tree: Tree) -> Array:
    """Check torque limits [Nm or N], and return them with shape (n_dof,); True stands for the description's effort limits.

    Raises:
        InputError: They are neither a number above 0 nor one for each entry of q; or the description has none.
    """
    n = tree.n_dof
    if isinstance(torque, bool | np.bool_) and torque:
        lacking = without_limit(tree)
        if lacking:
            raise InputError(
                "torque", f"the description has no effort limit above 0 for {', '.join(lacking)}; give numbers [Nm or N]"
            )
        return tree.effort_limits
    return _numbers_above_0("torque", torque, n, f"True, a number above 0, or {n} of them, is expected [Nm or N]")


def as_torque_rates(torque_rate: ArrayLike, tree: Tree) -> Array:
    """Check limits of the torques' rates of change [Nm/s or N/s], and return them with shape (n_dof,).

    Raises:
        InputError: They are neither a number above 0 nor one for each entry of q.
    """
    n = tree.n_dof
    return _numbers_above_0("torque_rate", torque_rate, n, f"a number above 0, or {n} of them, is expected [Nm/s or N/s]")


def known_limits(tree: Tree) -> Array:
    """The description's effort limits [Nm or N], shape (n_dof,); infinite where there is none above 0."""
    return np.where(tree.effort_limits > 0.0, tree.effort_limits, np.inf)


def without_limit(tree: Tree) -> tuple[str, ...]:
    """The names of the entries of q without an effort limit above 0 in the description."""
    return tuple(name for name, limit in zip(entry_names(tree), known_limits(tree), strict=True) if limit == np.inf)


def _numbers_above_0(name: str, given: ArrayLike, n: int, expected: str) -> Array:
    """Check one number above 0, or n of them, and return n."""
    numbers = None if isinstance(given, bool | np.bool_) else as_floats(name, given)
    if numbers is None or numbers.shape not in {(), (n,)} or not (numbers > 0.0).all():
        raise InputError(name, f"{given!r}; {expected}")
    return np.full(n, numbers)


def max_payloads(own: Array, of_one_kilogram: Array, most: Array) -> Array:
    """The payload [kg] that each motor can bear beside the robot's own torque, in the shape of ``own``.

    With the torque t per kilogram, the torque of the payload m is own + m t. So |own + m t| <= most holds up to
    m = (most - sign(t) own) / |t|.
    """
    felt = np.abs(of_one_kilogram) > _MIN_TORQUE
    room = most - np.sign(of_one_kilogram) * own
    masses = np.divide(room, np.abs(of_one_kilogram), out=np.full(room.shape, np.inf), where=felt)
    return np.where(np.abs(own) <= most, masses, 0.0)
