"""Reads the limits of torques that a caller gives, and finds the payload within them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError
from ulna.kinematics.tree import Tree, entry_names

Array = NDArray[np.float64]
_FELT = 1e-11  # [Nm or N]: a torque of 1 kg that is smaller is rounding


def as_effort_limits(torque: ArrayLike, tree: Tree) -> Array:
    """The limits of torques [Nm or N], shape (n_dof,): those of the description for True.

    Raises:
        InputError: They are neither a number above 0 nor one for each entry of q; or the description states none.
    """
    n = tree.n_dof
    if isinstance(torque, bool | np.bool_) and torque:
        lacking = without_limit(tree)
        if lacking:
            raise InputError(
                "torque", f"the description states no effort above 0 of {', '.join(lacking)}; give numbers [Nm or N]"
            )
        return tree.effort_limits
    return _numbers_above_0("torque", torque, n, f"True, a number above 0, or {n} of them, is expected [Nm or N]")


def as_torque_rates(torque_rate: ArrayLike, tree: Tree) -> Array:
    """The limits of the rates of torques [Nm/s or N/s], shape (n_dof,).

    Raises:
        InputError: They are neither a number above 0 nor one for each entry of q.
    """
    n = tree.n_dof
    return _numbers_above_0("torque_rate", torque_rate, n, f"a number above 0, or {n} of them, is expected [Nm/s or N/s]")


def known_limits(tree: Tree) -> Array:
    """The limits of effort that the description states [Nm or N], shape (n_dof,); infinite where it states none above 0."""
    return np.where(tree.effort_limits > 0.0, tree.effort_limits, np.inf)


def without_limit(tree: Tree) -> tuple[str, ...]:
    """The entries of q of which the description states no effort above 0."""
    return tuple(name for name, limit in zip(entry_names(tree), known_limits(tree), strict=True) if limit == np.inf)


def _numbers_above_0(name: str, given: ArrayLike, n: int, expected: str) -> Array:
    """A number above 0 for each of n joints: one for all, or n."""
    numbers = None if isinstance(given, bool | np.bool_) else as_floats(name, given)
    if numbers is None or numbers.shape not in {(), (n,)} or not (numbers > 0.0).all():
        raise InputError(name, f"{given!r}; {expected}")
    return np.full(n, numbers)


def largest_masses(own: Array, of_one_kilogram: Array, most: Array) -> Array:
    """The mass [kg] that each motor bears beside its own torque, of the shape of ``own``.

    The torque is own + m t, with that of one kilogram t. So |own + m t| <= most for m up to (most - sign(t) own) / |t|.
    """
    felt = np.abs(of_one_kilogram) > _FELT
    room = most - np.sign(of_one_kilogram) * own
    masses = np.divide(room, np.abs(of_one_kilogram), out=np.full(room.shape, np.inf), where=felt)
    return np.where(np.abs(own) <= most, masses, 0.0)
