"""Defines constraints of a motion: a link stays near a pose, line, plane or orientation, or in a box."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats, as_number, as_switch
from ulna.description.pose import as_one_pose, inverse
from ulna.errors import InputError
from ulna.ik.task import Task, as_task
from ulna.kernels.ik.search_layout import POINTING

Array = NDArray[np.float64]
AWAY, TURN = 1e-4, float(np.radians(0.1))  # [m], [rad]: default tolerances for a task without slack
_MIN_TOLERANCE = 1e-6  # [m or rad]
AIM = 0.5  # share of a tolerance that a projection or inverse kinematics aims to stay within
_FREE = float("inf")
_UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Keep:
    """A constraint of a motion: a link stays near a pose at all times, within the tolerances of a task.

    The tolerances are the task's slack. The displacement from the pose along each axis is at most the slack of that axis. The
    angle of the rotation is at most the slack of the rotation, which is one number. If the rotation about ``task.axis`` is free,
    the angle between the axes counts. A motion that satisfies the constraint satisfies its task. Straight lines in joint space
    cannot satisfy an equality, so a slack of 0 becomes 0.1 mm or 0.1 degrees.

    Attributes:
        task: The constrained components of the pose, and their tolerances, at least 1e-6 [m or rad] each.
        T: The reference pose T_base_link, shape (4, 4), or T_other_link with ``relative_to``. None: the pose at the start of the
            motion.
        link: The constrained link. None: the link that is planned for, or the tip.
        along: A direction in the base, or in ``relative_to``, shape (3,). If given, the constrained axis is the link's direction
            that points along it at the start, instead of ``task.axis``.
        relative_to: A reference link. None: the base.
        towards: Whether the axis points from the link's origin towards the origin of T, instead of along T's axis.

    Raises:
        InputError: ``task`` is not a task, or a slack is too small. The slacks of its rotation differ, or are pi or more. T is
            not a pose. ``along`` is not a direction, or the task has no axis. ``towards`` is given for a task without an axis, or
            without T. ``relative_to`` is the link itself.

    Example:
        >>> import ulna
        >>> panda = ulna.load("panda")
        >>> turned = panda.home + 0.0
        >>> turned[0] += 1.0
        >>> plan = panda.plan(panda.home, turned, keep=ulna.Keep.upright(within=0.1))
        >>> plan.certified, plan.worst_violation <= 1
        (True, True)
    """

    task: Task
    T: Array | None = None
    link: str | None = None
    along: tuple[float, float, float] | None = None
    relative_to: str | None = None
    towards: bool = False

    def __post_init__(self) -> None:
        task = as_task(self.task)
        slack = [s or default for s, default in zip(task.slack, (AWAY,) * 3 + (TURN,) * 3, strict=True)]
        if min(slack) < _MIN_TOLERANCE:
            raise InputError("task", f"a slack of {min(slack):.3g}; at least {_MIN_TOLERANCE:g} m or rad is expected")
        turns = {s for s in slack[3:] if s < _FREE}
        if len(turns) > 1 or not max(turns, default=0.0) < np.pi:
            raise InputError("task", f"slacks {slack[3:]} of the rotation; one angle below pi is expected where it is not free")
        object.__setattr__(self, "task", task if tuple(slack) == task.slack else Task(tuple(slack), task.axis))
        if self.T is not None:
            object.__setattr__(self, "T", as_one_pose(self.T))
            self.T.setflags(write=False)
        if self.along is not None:
            if not self.keeps_axis or self.T is not None:
                raise InputError("along", "requires a task that leaves the rotation about an axis free, and no pose")
            object.__setattr__(self, "along", _direction("along", self.along))
        if as_switch("towards", self.towards) and (not self.keeps_axis or self.T is None):
            raise InputError("towards", "requires a task that leaves the rotation about an axis free, and a pose")
        if self.relative_to is not None and self.relative_to == self.link:
            raise InputError("relative_to", f"{self.link!r} never moves relative to itself; another link is expected")

    @classmethod
    def upright(
        cls, within: float = 0.09, *, axis: ArrayLike | None = None, along: ArrayLike = _UP, link: str | None = None
    ) -> Keep:
        """Keep the link's direction that points up at the start within an angle of up; position and yaw are free.

        Args:
            within: The angle [rad].
            axis: The direction of the link to constrain, in its axes, shape (3,); unless given, its up direction at the start.
            along: The direction in the base to keep it near, shape (3,), instead of up.
            link: The link.

        Raises:
            InputError: An argument is invalid.
        """
        turn = _angle("within", within)
        slack = (_FREE, _FREE, _FREE, turn, turn, _FREE)
        if axis is None:
            return cls(Task(slack), link=link, along=_direction("along", along))
        task, other = Task(slack, _direction("axis", axis)), Task(slack, _direction("along", along))
        return cls(task, other.frame @ inverse(task.frame), link)

    @classmethod
    def orientation(cls, within: float = TURN, *, T: ArrayLike | None = None, link: str | None = None) -> Keep:
        """Keep the link's orientation within an angle [rad] of T or of the start; the position is free.

        Raises:
            InputError: An argument is invalid.
        """
        turn = _angle("within", within)
        return cls(Task((_FREE, _FREE, _FREE, turn, turn, turn)), T, link)  # type: ignore[arg-type]

    @classmethod
    def on_line(cls, a: ArrayLike, b: ArrayLike, *, within: float = 1e-3, link: str | None = None) -> Keep:
        """Keep the link's origin near the infinite line through two points.

        It stays in a square bar around the line, whose corners are ``within`` away.

        Args:
            a: A point in the base [m], shape (3,).
            b: Another point, shape (3,).
            within: The largest distance from the line [m].
            link: The link.

        Raises:
            InputError: An argument is invalid, or the points are nearer than 1e-9 m.
        """
        a, b = _point("a", a), _point("b", b)
        if not np.linalg.norm(b - a) > 1e-9:
            raise InputError("b", "a point other than the first is expected")
        side = _tolerance("within", within) / np.sqrt(2.0)
        T = Task.pointing(_direction("b", b - a)).frame.copy()
        T[:3, 3] = a
        return cls(Task((side, side, _FREE, _FREE, _FREE, _FREE)), T, link)

    @classmethod
    def in_plane(cls, T: ArrayLike, *, within: float = AWAY, link: str | None = None) -> Keep:
        """Keep the link's origin within a distance [m] of the plane z = 0 of a pose T_base_plane.

        Raises:
            InputError: An argument is invalid.
        """
        return cls(Task((_FREE, _FREE, _tolerance("within", within), _FREE, _FREE, _FREE)), as_one_pose(T), link)

    @classmethod
    def inside(cls, extents: ArrayLike, T: ArrayLike, *, link: str | None = None) -> Keep:
        """Keep the link's origin in a box of the workspace.

        Args:
            extents: The box's full edge lengths [m], shape (3,); an infinite length leaves that direction free.
            T: The pose T_base_box of the box's center, shape (4, 4).
            link: The link.

        Raises:
            InputError: An argument is invalid.
        """
        extents = as_floats("extents", extents)
        if extents.shape != (3,) or not (extents >= 2 * _MIN_TOLERANCE).all() or not extents.min() < _FREE:
            raise InputError("extents", f"three lengths [m] of at least {2 * _MIN_TOLERANCE:g} are expected, one at least finite")
        return cls(Task((*(extents / 2).tolist(), _FREE, _FREE, _FREE)), as_one_pose(T), link)

    @classmethod
    def looking_at(
        cls,
        point: ArrayLike,
        *,
        axis: ArrayLike = _UP,
        within: float = 0.09,
        link: str | None = None,
        relative_to: str | None = None,
    ) -> Keep:
        """Keep an axis through the link's origin pointing at a point within an angle, as a camera at a part.

        The distance to the point and the rotation about the axis are free.

        Args:
            point: The point [m], shape (3,), in the base, or in the frame of ``relative_to``.
            axis: The direction of the link, in its axes, shape (3,).
            within: The angle [rad].
            link: The link.
            relative_to: A link that the point moves with.

        Raises:
            InputError: An argument is invalid.
        """
        turn = _angle("within", within)
        T, task = np.eye(4), Task((_FREE, _FREE, _FREE, turn, turn, _FREE), _direction("axis", axis))
        T[:3, 3] = _point("point", point)
        return cls(task, T, link, relative_to=relative_to, towards=True)

    @classmethod
    def together(cls, link: str, other: str, *, T: ArrayLike | None = None, within: tuple[float, float] = (AWAY, 1e-3)) -> Keep:
        """Keep the relative pose of two links, such as two hands that hold one object.

        Args:
            link: One link.
            other: The other link.
            T: The pose T_link_other, shape (4, 4); the relative pose at the start for None.
            within: The tolerances: along each axis of T [m], and of the angle [rad].

        Raises:
            InputError: An argument is invalid.
        """
        both = as_floats("within", within)
        if both.shape != (2,):
            raise InputError("within", f"{within!r}; two tolerances are expected: a distance [m] and an angle [rad]")
        away, turn = _tolerance("within", both[0].item()), _angle("within", both[1].item())
        return cls(Task((away,) * 3 + (turn,) * 3), T, other, relative_to=link)  # type: ignore[arg-type]

    def at_start(self, T: Array, link: str) -> Keep:
        """The constraint on a motion that begins with the link at the pose T, shape (4, 4), relative to ``relative_to``."""
        task = self.task if self.along is None else Task(self.task.slack, tuple((T[:3, :3].T @ self.along).tolist()))
        return replace(self, task=task, T=T if self.T is None else self.T, link=link, along=None)

    def target(self, link: str | None) -> tuple[Array, str | None, Task]:
        """The target for inverse kinematics: a pose, shape (4, 4), the link, and a task with half the tolerances.

        link: the default link.

        Raises:
            InputError: The constraint has no pose, is relative to another link, or is for another link than ``link``.
        """
        if self.T is None:
            raise InputError("T", "a constraint without a pose refers to the start of a motion; give it a pose, or an axis")
        if self.towards or self.relative_to is not None:
            raise InputError("T", "inverse kinematics needs a pose in the base; this constraint is relative to a link or a point")
        if link is not None and self.link not in {None, link}:
            raise InputError("link", f"{link!r}, but the constraint is for {self.link!r}")
        slack = tuple((AIM * np.array(self.task.slack)).tolist())
        return self.T, link if self.link is None else self.link, Task(slack, self.task.axis)

    @property
    def pose(self) -> Array:
        """The pose T of a constraint that has one; see ``at_start``."""
        if self.T is None:
            raise AssertionError("the pose at the start is not known")
        return self.T

    @property
    def keeps_axis(self) -> bool:
        """Whether only the rotation about an axis is free."""
        return self.task.kind == POINTING

    def __setstate__(self, state: dict) -> None:
        self.__dict__.update(state)
        if self.T is not None:
            self.T.setflags(write=False)


def _tolerance(name: str, value: float) -> float:
    return as_number(name, value, _MIN_TOLERANCE, f"a tolerance of at least {_MIN_TOLERANCE:g} m or rad")


def _angle(name: str, value: float) -> float:
    expected = f"an angle [rad] from {_MIN_TOLERANCE:g} to below pi"
    return as_number(name, value, _MIN_TOLERANCE, expected, most=float(np.nextafter(np.pi, 0.0)))


def _point(name: str, value: ArrayLike) -> Array:
    point = as_floats(name, value)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise InputError(name, f"{value!r}; a point, three finite numbers [m], is expected")
    return point


def _direction(name: str, vector: ArrayLike) -> tuple[float, float, float]:
    direction = as_floats(name, vector)
    length = float(np.linalg.norm(direction)) if direction.shape == (3,) else 0.0
    if not 1e-9 < length < _FREE:
        raise InputError(name, f"{vector!r}; a direction of three numbers is expected")
    x, y, z = (direction / length).tolist()
    return x, y, z
