"""Runs motions dry: with every check of a real arm, and without motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.arms.arm import FR3, ArmModel, Record
from ulna.arms.commands import PERIOD, START_TOLERANCE, approach, as_tolerance, commands_of
from ulna.arms.steering import Goal, Steering
from ulna.description.arrays import as_floats
from ulna.errors import InputError
from ulna.planning.trajectory import Trajectory
from ulna.servo.servo import Servo

Array = NDArray[np.float64]


class Recorder:
    """A simulated ``Arm``: it refuses what a real one would refuse, records the commands, and takes no time.

    The measured position before a command is the command before it.

    Attributes:
        model: The limits against which a motion is checked.
        records: The ``Record`` of each run, the last one last.
    """

    def __init__(self, q: ArrayLike, *, model: ArmModel = FR3, start_tolerance: float = START_TOLERANCE) -> None:
        """Start an arm at rest at q.

        Args:
            q: Its position [rad or m], shape (n_dof,).
            model: The arm that it stands for; by default a Franka Research 3.
            start_tolerance: Maximum distance of a joint from a motion's start [rad or m], at most 0.03.

        Raises:
            InputError: q is not one position for each joint within the limits, or the tolerance is out of range.
        """
        q = np.array(as_floats("q", q))
        if q.shape != (model.n_dof,) or not np.isfinite(q).all():
            raise InputError("q", f"shape {q.shape}; {model.n_dof} positions within the arm's limits are expected")
        excess = np.maximum(model.lower - q, q - model.upper)
        if (excess > 0.0).any():
            k = int(excess.argmax())
            raise InputError("q", f"entry {k} is {q[k]:.6g}, {excess[k]:.3g} beyond the limits of the {model.name}")
        self.model, self.records, self._q, self._tolerance = model, [], q, as_tolerance(start_tolerance)

    @property
    def q(self) -> Array:
        """The end of the last run [rad or m], shape (n_dof,)."""
        return self._q.copy()

    def run(self, motion: Trajectory, *, speed: float = 1.0) -> Record:
        """Record the commands of a motion, in no time; see ``Arm.run``.

        Raises:
            InputError: The motion or the speed is refused.
        """
        body = commands_of(motion, self.model, self._q, speed=speed, tolerance=self._tolerance)
        commands = np.concatenate([approach(self._q, body[0]), body])
        measured = np.concatenate([self._q[None], commands[:-1]])
        times, q = PERIOD * np.arange(len(commands), dtype=np.float64), commands[-1].copy()
        record = Record(
            times, commands, measured, motion.joint_names, goal=motion.q[-1].copy(), q_end=q, arrival=self.model.arrival
        )
        self.records += [record]  # before the position, in case of an interruption
        self._q = q
        return record

    def follow(self, servo: Servo, goal: Goal) -> Record:
        """Record the commands of a servo, in no time; see ``Arm.follow``.

        Raises:
            InputError: The servo is refused, or cannot start at the arm's position.
        """
        steering, commands = Steering(servo, self.model, goal), [self._q]
        steering.begin(self._q)
        while not steering.ended:
            commands.append(steering.step(commands[-1]))
        commanded = np.array(commands[1:])
        times = PERIOD * np.arange(len(commanded), dtype=np.float64)
        q = commanded[-1].copy()
        record = Record(times, commanded, np.array(commands[:-1]), servo.joint_names, q_end=q, arrival=self.model.arrival)
        self.records += [record]
        self._q = q
        return record

    def stop(self) -> None:
        """Do nothing: a dry run takes no time, so none is running."""
