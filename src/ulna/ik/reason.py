"""Defines the reason why something was not found, and the numbers and names from which it is made.

``Reason`` is the sentence and the data that the caller gets. ``Explanation`` contains the numbers and names.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reason:
    """The reason why there is no solution, plan or path. It is false, and empty, if there is one.

    Attributes:
        sentence: The reason in words, with numbers and units; also ``str(reason)``.
        data: The data behind the sentence. For ``inverse_kinematics``: a dict, for example with the excess of each joint over its
            limit. For ``plan``: a ``Report`` of the pairs in contact, the ``IKResult`` of the goal, or a ``SpentBudget``. For
            ``follow``: an ``Ending``.

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
        reach_excess: The distance of an unreachable target from the reach [m], by its index in the batch.
        limit_excess: The excess of the joints over their bounds [rad or m], shape (n_dof,), by the target's index.
        collisions: The names of the colliding pairs, by the target's index.
        reach: For one target: the comparison in the certificate, in words.
        entry_names: A name for every entry of q.
        task_axes: The axes of the task in the link, shape (3, 3); None if they are the link's own.
        trace: For one target: one row a step (``IKResult.trace``); None unless it was recorded.
    """

    reach_excess: Mapping[int, float] = field(default_factory=dict)
    limit_excess: Mapping[int, Array] = field(default_factory=dict)
    collisions: Mapping[int, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    reach: str = ""
    entry_names: tuple[str, ...] = ()
    task_axes: Array | None = None
    trace: Array | None = None

    def renumbered(self, order: NDArray[np.int64]) -> "Explanation":
        """A copy with target index i replaced by order[i]."""
        kept = {
            name: {int(order[i]): value for i, value in getattr(self, name).items()}
            for name in ("reach_excess", "limit_excess", "collisions")
        }
        return replace(self, **kept)


NOTHING_TO_EXPLAIN = Explanation()
