"""Says why something was not found: a sentence with its data for the caller, and what that is made from."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reason:
    """Why there is no solution, no plan or no path. It is false, and its sentence empty, where there is one.

    Attributes:
        sentence: Why, in words, with numbers and units; also ``str(reason)``.
        data: What the sentence is made from. Of ``inverse_kinematics``: a dict by names, such as how far each joint would have to
            go beyond its limit. Of ``plan``: a ``Report`` of the pairs that touch, the ``IKResult`` of the goal, or a
            ``SpentBudget``. Of ``follow``: an ``Ending``.

    Example:
        >>> import ulna
        >>> found = ulna.load("panda").inverse_kinematics(ulna.pose((2.0, 0.0, 0.0)))
        >>> bool(found), bool(found.reason), sorted(found.reason.data)
        (False, True, ['reach_excess'])
    """

    sentence: str = ""
    data: Any = None

    def __bool__(self) -> bool:
        return bool(self.sentence)

    def __str__(self) -> str:
        return self.sentence


NO_REASON = Reason()


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
        trace: For one target: a row a step (``IKResult.trace``); None unless it was recorded.
    """

    reach_excess: Mapping[int, float] = field(default_factory=dict)
    limit_excess: Mapping[int, Array] = field(default_factory=dict)
    collisions: Mapping[int, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    reach: str = ""
    entry_names: tuple[str, ...] = ()
    task_axes: Array | None = None
    trace: Array | None = None

    def renumbered(self, order: NDArray[np.int64]) -> "Explanation":
        """With number i of a target replaced by order[i]."""
        kept = {
            name: {int(order[i]): value for i, value in getattr(self, name).items()}
            for name in ("reach_excess", "limit_excess", "collisions")
        }
        return replace(self, **kept)


NOTHING_TO_EXPLAIN = Explanation()
