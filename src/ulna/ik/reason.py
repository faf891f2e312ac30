"""Says why something was not found, as a sentence and as data."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)
class Reason:
    """Why there is no solution, no plan or no path. It is false, and its sentence empty, where there is one.

    Attributes:
        sentence: Why, in words, with numbers and units; also ``str(reason)``.
        data: What the sentence is made from. Of ``inverse_kinematics``: a dict by names, such as how far each joint would have to
            go beyond its limit. Of ``plan``: a ``Report`` of the pairs that touch, the ``IKResult`` of the goal, or how far the
            search came. Of ``follow``: an ``Ending``.

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
