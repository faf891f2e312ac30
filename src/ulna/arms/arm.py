"""States what a driver of an arm has, whoever made the arm."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.arms.arm_model import ArmModel
from ulna.arms.record import Record
from ulna.planning.trajectory import Trajectory


class Arm(Protocol):
    """An arm that follows motions. A driver of another arm has these members, and needs no base class.

    Nothing but ``run`` moves the arm.
    """

    @property
    def model(self) -> ArmModel:
        """What a motion is checked against before it begins."""
        ...

    @property
    def q(self) -> NDArray[np.float64]:
        """The measured joint positions [rad or m], shape (n_dof,).

        Raises:
            ArmConnectionError: The arm cannot be reached.
        """
        ...

    def run(self, motion: Trajectory, *, speed: float = 1.0) -> Record:
        """Follow a motion, and return when it has ended or ``stop`` was called.

        Args:
            motion: A motion with limits of jerk, from where the arm is.
            speed: The share of the motion's speed, above 0 and at most 1: 0.5 takes twice as long along the same path.

        Returns:
            The commands and the measured positions.

        Raises:
            InputError: The motion or the speed is refused. The arm has not moved.
            ArmConnectionError: The connection was lost.
            ArmError: The arm has stopped by itself.
        """
        ...

    def stop(self) -> None:
        """Stop a motion that runs in another thread; nothing if none runs."""
        ...
