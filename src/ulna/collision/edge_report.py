"""Holds the result of checking the straight line between two configurations."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import TruthError


@dataclass(frozen=True, eq=False)
class EdgeReport:
    """Whether the robot touches anything from q_a to q_b; of one edge, a bool too: ``if robot.edge_in_collision(...)``.

    Attributes:
        in_collision: True if it does: a bool for one edge, else shape (...,).
        free_until: The fraction of the line, in [0, 1], that is certainly free; 1 if all of it is. Where ``in_collision``,
            something touches here, or is as near as the resolution.
        q: The configuration at ``free_until`` [rad or m], shape (..., n_dof).
    """

    in_collision: Any
    free_until: Any
    q: NDArray[np.float64]

    def __bool__(self) -> bool:
        if np.ndim(self.in_collision):
            raise TruthError("an EdgeReport", "report.in_collision")
        return bool(self.in_collision)

    def __str__(self) -> str:
        if np.ndim(self.in_collision):
            return f"{np.count_nonzero(self.in_collision)} of {np.size(self.in_collision)} edges in collision"
        return f"collision at {self.free_until:.4f} of the way" if self.in_collision else "free"
