"""Holds what a motion is checked against: the joints of an arm, as its maker states them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ArmModel:
    """A kind of arm.

    Attributes:
        name: Its name in messages.
        lower: The least positions [rad or m], shape (n_dof,).
        upper: The greatest positions [rad or m], shape (n_dof,).
        limits: Those of velocity, acceleration and jerk, as ``Trajectory.check`` takes them: a name, or a file.

    Raises:
        InputError: The positions are not two arrays of one length, or a lower one is above the upper one.
    """

    name: str
    lower: Array
    upper: Array
    limits: str | Path

    def __post_init__(self) -> None:
        lower, upper = (np.array(as_floats(name, getattr(self, name))) for name in ("lower", "upper"))
        if lower.ndim != 1 or lower.shape != upper.shape or not (lower <= upper).all():
            raise InputError("lower, upper", f"shapes {lower.shape} and {upper.shape}; two arrays of n_dof limits are expected")
        for name, array in (("lower", lower), ("upper", upper)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_dof(self) -> int:
        """How many joints it has."""
        return len(self.lower)


FR3 = ArmModel(  # source: Franka Robotics, "Robot and interface specifications", the limits of the Franka Research 3
    "Franka Research 3",
    np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159]),
    np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159]),
    "fr3",
)
