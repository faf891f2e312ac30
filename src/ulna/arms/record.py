"""Holds what was commanded and measured while an arm followed a motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.table_file import write_table

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """A run of an arm: a row for each command that was sent.

    Attributes:
        times: The time of each command since the first [s], shape (n,).
        commanded: The commands [rad or m], shape (n, n_dof).
        measured: The positions that were measured just before each command was sent [rad or m], shape (n, n_dof).
        joint_names: Those of the entries of q.
        stopped: Whether ``stop`` ended the run before the motion's end.
        lost: How many periods passed without a command.
    """

    times: Array
    commanded: Array
    measured: Array
    joint_names: tuple[str, ...]
    stopped: bool = False
    lost: int = 0

    def __post_init__(self) -> None:
        for array in (self.times, self.commanded, self.measured):
            array.setflags(write=False)

    @property
    def duration(self) -> float:
        """The time from the first command to the last [s]."""
        return float(self.times[-1]) if len(self.times) else 0.0

    @property
    def tracking_error(self) -> float:
        """The greatest difference of any joint from the command sent one period before [rad or m].

        It includes the time that the controller needs, in which a fast joint is left behind.
        """
        return float(np.abs(self.measured[1:] - self.commanded[:-1]).max(initial=0.0))

    def to_csv(self, path: str | Path) -> None:
        """Write a table: a line of names, then a line for each command, with the measured positions behind it.

        Raises:
            FileError: The file cannot be written.
        """
        names = [f"{kind}{name}" for kind in ("", "measured_") for name in self.joint_names]
        write_table(path, ["time", *names], np.column_stack([self.times, self.commanded, self.measured]))

    def __str__(self) -> str:
        how = "stopped" if self.stopped else "run to its end"
        lost = f", {self.lost} periods without a command" if self.lost else ""
        return f"{how} in {self.duration:.3f} s, tracking error {self.tracking_error:.2g}{lost}"
