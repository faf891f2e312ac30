"""Defines the interface of a driver: the arm's model, the motions that it follows, and the record of each run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_floats
from ulna.description.file_bytes import write_table
from ulna.errors import InputError
from ulna.planning.trajectory import Trajectory
from ulna.servo.servo import Servo

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ArmModel:
    """A kind of arm.

    Attributes:
        name: Its name in messages.
        lower: Minimum positions [rad or m], shape (n_dof,).
        upper: Maximum positions [rad or m], shape (n_dof,).
        limits: Limits of velocity, acceleration and jerk, as ``Trajectory.check`` takes them: a name, or a file.
        lag: Maximum delay of the arm behind its commands [s].
        deviation: Maximum distance of a joint from all commands within ``lag`` [rad or m]; beyond it, something holds the arm.
        arrival: Maximum distance of a joint from its goal at the end of a run [rad or m].

    Raises:
        InputError: The positions are not two arrays of one length, or a lower one is above the upper one.
    """

    name: str
    lower: Array
    upper: Array
    limits: str | Path
    lag: float = 0.2
    deviation: float = 0.1
    arrival: float = 0.03

    def __post_init__(self) -> None:
        lower, upper = (np.array(as_floats(name, getattr(self, name))) for name in ("lower", "upper"))
        if lower.ndim != 1 or lower.shape != upper.shape or not (lower <= upper).all():
            raise InputError("lower, upper", f"shapes {lower.shape} and {upper.shape}; two arrays of n_dof limits are expected")
        for name, array in (("lower", lower), ("upper", upper)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_dof(self) -> int:
        """The number of joints."""
        return len(self.lower)


FR3 = ArmModel(  # source: Franka Robotics, "Robot and interface specifications", the limits of the Franka Research 3
    "Franka Research 3",
    np.array([-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159]),
    np.array([2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159]),
    "fr3",
)


@dataclass(frozen=True, eq=False)
class Record:
    """A run of an arm: a row for each command.

    It is true if the arm ended at its goal.

    Attributes:
        times: The time of each command since the first [s], shape (n,).
        commanded: The commands [rad or m], shape (n, n_dof).
        measured: The positions measured just before each command was sent [rad or m], shape (n, n_dof).
        joint_names: The names of the entries of q.
        stopped: Whether ``stop`` ended the run before the motion's end.
        lost: The number of periods without a command.
        goal: The goal of the run [rad or m], shape (n_dof,); by default the last command.
        q_end: The measured position after the run [rad or m], shape (n_dof,); by default the last row of ``measured``.
        arrival: Maximum distance of a joint from the goal that counts as arrived [rad or m].
    """

    times: Array
    commanded: Array
    measured: Array
    joint_names: tuple[str, ...]
    stopped: bool = False
    lost: int = 0
    goal: Array = field(default=None)  # type: ignore[assignment] - __post_init__ puts the last row there
    q_end: Array = field(default=None)  # type: ignore[assignment]
    arrival: float = ArmModel.arrival

    def __post_init__(self) -> None:
        for name, rows in (("goal", self.commanded), ("q_end", self.measured)):
            if getattr(self, name) is None:
                last = rows[-1] if len(rows) else np.full(len(self.joint_names), np.nan)
                object.__setattr__(self, name, np.array(last))
        for array in (self.times, self.commanded, self.measured, self.goal, self.q_end):
            array.setflags(write=False)

    def __bool__(self) -> bool:
        return self.arrived

    @property
    def arrived(self) -> bool:
        """Whether the run was not stopped, and every joint ended within ``arrival`` of its goal."""
        return not self.stopped and bool((np.abs(self.q_end - self.goal) <= self.arrival).all())

    @property
    def ended(self) -> str:
        """The end of the run in words; names the joint farthest from its goal."""
        if self.arrived:
            return "at the goal"
        off = np.abs(self.q_end - self.goal)
        joint = int(np.argmax(off))  # NaN without a measurement: the first joint
        return (
            f"{off[joint]:.2g} rad from the goal: {self.joint_names[joint]} is at {self.q_end[joint]:.4g}, "
            f"and the goal is {self.goal[joint]:.4g}"
        )

    @property
    def duration(self) -> float:
        """The time from the first command to the last [s]."""
        return float(self.times[-1]) if len(self.times) else 0.0

    @property
    def tracking_error(self) -> float:
        """The maximum difference of any joint from the command sent one period before [rad or m].

        It includes the delay of the controller, by which a fast joint lags behind.
        """
        return float(np.abs(self.measured[1:] - self.commanded[:-1]).max(initial=0.0))

    def to_csv(self, path: str | Path) -> None:
        """Write a table: a line of names, then a line for each command followed by the measured positions.

        Raises:
            FileError: The file cannot be written.
        """
        names = [f"{kind}{name}" for kind in ("", "measured_") for name in self.joint_names]
        write_table(path, ["time", *names], np.column_stack([self.times, self.commanded, self.measured]))

    def __str__(self) -> str:
        how = "stopped" if self.stopped else "run to its end"
        lost = f", {self.lost} periods without a command" if self.lost else ""
        return f"{how} in {self.duration:.3f} s, {self.ended}, tracking error {self.tracking_error:.2g}{lost}"


class Arm(Protocol):
    """An arm that follows motions. A driver of another arm has these members, and needs no base class.

    Only ``run`` and ``follow`` move the arm.
    """

    @property
    def model(self) -> ArmModel:
        """The limits against which a motion is checked before it starts."""
        ...

    @property
    def q(self) -> NDArray[np.float64]:
        """The measured joint positions [rad or m], shape (n_dof,).

        Raises:
            ArmConnectionError: The arm cannot be reached.
        """
        ...

    def run(self, motion: Trajectory, *, speed: float = 1.0) -> Record:
        """Follow a motion; returns when it has ended or ``stop`` was called.

        Args:
            motion: A motion with jerk limits, from the arm's current position.
            speed: The fraction of the motion's speed, above 0 and at most 1: 0.5 takes twice as long along the same path.

        Returns:
            The commands and the measured positions; true if the arm ended at the motion's end.

        Raises:
            InputError: The motion or the speed is refused. The arm has not moved.
            ArmConnectionError: The connection was lost.
            ArmError: The arm has stopped by itself.
        """
        ...

    def follow(self, servo: Servo, goal: Callable[[float, NDArray[np.float64]], Mapping[str, Any] | None]) -> Record:
        """Steer the arm by a servo until it is at rest after the goal's end, or ``stop`` was called.

        Args:
            servo: A servo of ``robot.servo(acceleration=..., jerk=...)``, with the controller's rate.
            goal: A function of the time [s] and of the measured q, shape (n_dof,), called once per period. It returns the
                arguments of ``Servo.step``, as {"pose": T} or {"twist": v}; None brings the arm to rest, which ends the run.

        Returns:
            The commands and the measured positions; true if the arm ended at its last command.

        Raises:
            InputError: The servo is refused, or the arm's position is not certified free. The arm has not moved.
            ArmConnectionError: The connection was lost.
            ArmError: The arm has stopped by itself.
        """
        ...

    def stop(self) -> None:
        """Stop a motion that runs in another thread; does nothing if none runs."""
        ...
