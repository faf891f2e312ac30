"""Holds what is known about targets that were not reached, and the trace of a search."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Explanation:
    """The numbers and names behind the statuses of a result.

    Attributes:
        reach_excess: By how much an unreachable target lies beyond the reach [m], by its number in the batch.
        limit_excess: How far joints would have to go beyond their bounds [rad or m], shape (n_dof,), by the target's number.
        collisions: The pairs of names that collide, by the target's number.
        reach: For one target: what the certificate compares, in words.
        entry_names: A name for every entry of q.
        task_axes: The axes of the task in the link, shape (3, 3); None where they are the link's own.
        trace: For one target: a row a step (``IKResult.trace``); None unless it was asked for.
    """

    reach_excess: Mapping[int, float] = field(default_factory=dict)
    limit_excess: Mapping[int, Array] = field(default_factory=dict)
    collisions: Mapping[int, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    reach: str = ""
    entry_names: tuple[str, ...] = ()
    task_axes: Array | None = None
    trace: Array | None = None

    def renumbered(self, order: NDArray[np.int64]) -> "Explanation":
        """The same for targets that have other numbers: number i becomes order[i]."""
        kept = {
            name: {int(order[i]): value for i, value in getattr(self, name).items()}
            for name in ("reach_excess", "limit_excess", "collisions")
        }
        return replace(self, **kept)


NOTHING_TO_EXPLAIN = Explanation()
