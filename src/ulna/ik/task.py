"""Defines the components of a pose that a search must reach: all, position, direction, or within tolerances."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError, did_you_mean
from ulna.kernels.ik.search_layout import POINTING, WHOLE_POSE, WITH_SLACK

_FREE = float("inf")
_ABOUT_Z = False, False, True


@dataclass(frozen=True)
class Task:
    """The components of a target pose that must be reached, and their tolerances.

    The error of a pose has six components: the displacement x, y, z [m] and the rotation vector about x, y, z [rad], in the
    target's axes. A component within its slack costs nothing; an infinite slack frees the component.

    Attributes:
        slack: Six numbers of at least 0, in the target's axes rotated so that z is along ``axis``. The rotation may be free about
            no axis, about z alone, or about all. If free about z, the link's ``axis`` is brought onto the target's by the
            smallest rotation.
        axis: A direction in the link's own axes, shape (3,).

    Raises:
        InputError: The slack is not six numbers of at least 0, frees the rotation about another axis only, or frees everything;
            or the axis is not a direction.

    Example:
        >>> Task.pointing(axis=(0, 0, 1)).slack
        (0.0, 0.0, 0.0, 0.0, 0.0, inf)
    """

    slack: tuple[float, ...] = (0.0,) * 6
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        given = as_floats("slack", self.slack)
        slack = tuple(given.ravel().tolist())
        if given.shape != (6,) or not all(s >= 0.0 for s in slack):
            raise InputError("slack", f"{self.slack!r}; six numbers of at least 0 are expected: x, y, z [m], rx, ry, rz [rad]")
        if _free_turns(slack) not in {(False, False, False), _ABOUT_Z, (True, True, True)}:
            raise InputError("slack", "the rotation may be free about z or altogether; axis= chooses what z is")
        if min(slack) == _FREE:
            raise InputError("slack", "every component is free, so there is nothing to search for")
        axis = as_floats("axis", self.axis)
        length = float(np.linalg.norm(axis)) if axis.shape == (3,) else 0.0
        if not 1e-9 < length < _FREE:
            raise InputError("axis", f"{self.axis!r}; a direction of three numbers is expected")
        object.__setattr__(self, "slack", slack)
        object.__setattr__(self, "axis", tuple((axis / length).tolist()))

    @classmethod
    def pose(cls) -> "Task":
        """Position and orientation."""
        return cls()

    @classmethod
    def position(cls) -> "Task":
        """The position of the link's origin; any orientation."""
        return cls((0.0, 0.0, 0.0, _FREE, _FREE, _FREE))

    @classmethod
    def pointing(cls, axis: ArrayLike = (0.0, 0.0, 1.0)) -> "Task":
        """The position, and the direction of one axis of the link, for drilling, pouring, or arms of five joints.

        The rotation about this axis is free.

        Args:
            axis: In the frame of the link, shape (3,); of any length above 0.

        Raises:
            InputError: ``axis`` is not such a vector.
        """
        return cls((0.0, 0.0, 0.0, 0.0, 0.0, _FREE), axis)  # type: ignore[arg-type]

    @property
    def kind(self) -> int:
        """The kernels' number for this task."""
        if not any(self.slack):
            return WHOLE_POSE
        return POINTING if _free_turns(self.slack) == _ABOUT_Z else WITH_SLACK

    @cached_property
    def turn(self) -> NDArray[np.float64] | None:
        """The rotation (3, 3) that brings z onto ``axis``; None if they are the same."""
        if self.axis == (0.0, 0.0, 1.0):
            return None
        a, b, c = self.axis
        x = np.array(((0.0, -c, b), (c, 0.0, -a), (-b, a, 0.0))[int(np.argmin(np.abs(self.axis)))])  # normal to the axis
        x /= np.linalg.norm(x)
        y = b * x[2] - c * x[1], c * x[0] - a * x[2], a * x[1] - b * x[0]
        turn = np.column_stack([x, y, self.axis])
        turn.flags.writeable = False
        return turn

    @cached_property
    def frame(self) -> NDArray[np.float64]:
        """The pose (4, 4) of the task's frame in the link: the link's frame, rotated."""
        T = np.eye(4)
        if self.turn is not None:
            T[:3, :3] = self.turn
        T.flags.writeable = False
        return T


def _free_turns(slack: tuple[float, ...]) -> tuple[bool, ...]:
    """Whether the rotation is free about x, y and z."""
    return tuple(s == _FREE for s in slack[3:])


_NAMED = {"pose": Task.pose(), "position": Task.position(), "pointing": Task.pointing()}


def as_task(task: "Task | str") -> Task:
    """The task: a ``Task`` itself, or the task of a name."""
    if isinstance(task, Task):
        return task
    named = _NAMED.get(task) if isinstance(task, str) else None
    if named is None:
        raise InputError("task", f"{task!r} is not a task{did_you_mean(str(task), _NAMED)}; or give an ulna.Task")
    return named
