"""The description of a robot as immutable data: links and joints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from enum import StrEnum
from math import inf
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_one_pose
from ulna.description.semantic import Srdf
from ulna.description.shapes import Shape
from ulna.errors import DescriptionError, InputError

_SYMMETRIC = 1e-9  # of the largest number of a tensor: less is rounding
_MAX_MASS = 1e12  # kg and kg m^2


class JointType(StrEnum):
    """The joint types of URDF."""

    FIXED = "fixed"
    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    PLANAR = "planar"
    FLOATING = "floating"


N_POSITIONS = {
    JointType.FIXED: 0,
    JointType.REVOLUTE: 1,
    JointType.CONTINUOUS: 1,
    JointType.PRISMATIC: 1,
    JointType.PLANAR: 3,
    JointType.FLOATING: 6,
}


def frozen(values, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """A read-only copy as float64 of the given shape."""
    array = np.array(values, dtype=np.float64).reshape(shape)
    array.setflags(write=False)
    return array


@dataclass(frozen=True)
class Limits:
    """Limits of one joint; infinite if the description gives none.

    Positions [rad or m], velocity [rad/s or m/s], effort [Nm or N], acceleration and deceleration [rad/s^2 or m/s^2], and jerk
    [rad/s^3 or m/s^3].
    """

    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    effort: float = inf
    acceleration: float = inf
    deceleration: float = inf
    jerk: float = inf


@dataclass(frozen=True)
class Safety:
    """The ``safety_controller`` of a joint: soft limits [rad or m], infinite if not given, and the gains."""

    k_velocity: float
    k_position: float = 0.0
    soft_lower: float = -inf
    soft_upper: float = inf


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = multiplier * position of ``joint`` + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Joint:
    """Joins ``child`` to ``parent``. ``origin`` is T_parent_joint at zero; ``axis`` is a unit vector in the joint's frame.

    ``damping`` [N m s/rad or N s/m] and ``friction`` [N m or N] are read and written; no torque includes them.

    Raises:
        InputError: The origin is not a rigid motion, or the axis is not three numbers.
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: NDArray[np.float64]
    axis: NDArray[np.float64]
    limits: Limits = Limits()
    mimic: Mimic | None = None
    line: int | None = None
    safety: Safety | None = None
    damping: float = 0.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen(as_one_pose(self.origin, "origin"), (4, 4)))
        object.__setattr__(self, "axis", frozen(self.axis, (3,)))

    def __reduce__(self):
        return _remake, (type(self), _contents(self))


@dataclass(frozen=True, eq=False)
class Body:
    """A shape on a link: ``pose`` is T_link_shape; ``color`` is red, green, blue, alpha in 0..1.

    ``excess`` is the largest distance by which a replacement shape exceeds its mesh [m]. It is sampled for convex pieces, a bound
    for covering balls, and None for any other shape.

    Raises:
        InputError: The pose is not a rigid motion.
    """

    name: str
    shape: Shape
    pose: NDArray[np.float64]
    color: tuple[float, float, float, float] | None = None
    excess: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", frozen(as_one_pose(self.pose, "pose"), (4, 4)))

    def __reduce__(self):
        return _remake, (type(self), _contents(self))


@dataclass(frozen=True, eq=False)
class Inertia:
    """The mass [kg], center of mass, shape (3,) [m], and inertia tensor, shape (3, 3) [kg m^2], of a part.

    The center is in the frame of the link. The tensor is about the center of mass, in the axes of the link.

    Raises:
        InputError: A number is not finite, the mass is negative, or the tensor is not symmetric.
    """

    mass: float
    center: NDArray[np.float64]
    tensor: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name, shape in (("mass", ()), ("center", (3,)), ("tensor", (3, 3))):
            values = as_floats(name, getattr(self, name))
            if values.shape != shape or not np.isfinite(values).all():
                raise InputError(name, f"{getattr(self, name)!r}; finite numbers of shape {shape} are expected")
            object.__setattr__(self, name, frozen(values, shape) if shape else float(values))
        if self.mass < 0:
            raise InputError("mass", f"{self.mass} kg is negative")
        if not np.allclose(self.tensor, self.tensor.T, rtol=0, atol=_SYMMETRIC * np.abs(self.tensor).max()):
            raise InputError("tensor", "is not symmetric")

    @classmethod
    def stated(cls, mass: float, moments: Iterable[float], T: NDArray[np.float64]) -> Inertia:
        """The inertia from moments xx, xy, xz, yy, yz, zz in the frame with pose ``T``, shape (4, 4).

        Raises:
            DescriptionError: A number is too large to compute with.
        """
        xx, xy, xz, yy, yz, zz = moments
        if max(map(abs, (mass, xx, xy, xz, yy, yz, zz))) > _MAX_MASS:
            raise DescriptionError(f"a mass or a moment is beyond {_MAX_MASS:g}")
        return cls(mass, np.zeros(3), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])).moved(T)

    def moved(self, T: NDArray[np.float64]) -> Inertia:
        """The same inertia in another frame, in which ``T`` is the pose of its own, shape (4, 4)."""
        R = T[:3, :3]
        tensor = R @ self.tensor @ R.T
        return Inertia(self.mass, T[:3, 3] + R @ self.center, (tensor + tensor.T) / 2)

    def __reduce__(self):
        return _remake, (type(self), _contents(self))


@dataclass(frozen=True)
class Link:
    """A rigid part with its visual shapes, its collision shapes and its inertia, which is None if not described."""

    name: str
    visuals: tuple[Body, ...] = ()
    collisions: tuple[Body, ...] = ()
    line: int | None = None
    inertia: Inertia | None = None


def _contents(value) -> tuple:
    return tuple(getattr(value, f.name) for f in fields(value))


def _remake(kind: type, contents: tuple):
    """A copy through the constructor, which freezes its arrays: pickle and deepcopy would leave them writable."""
    return kind(*contents)


@dataclass(frozen=True)
class LeftOut:
    """A faulty part of a document, omitted since no pose depends on it, or read as other programs do.

    Attributes:
        where: The joint, the link or the document.
        message: The omitted part, and the reason.
        line: Its line.
        is_warned: Whether ``load`` warns of it, and not only ``inspect``.
        is_note: Whether it is meant for other programs, so that ``inspect`` does not warn of it either.
    """

    where: str
    message: str
    line: int | None = None
    is_warned: bool = True
    is_note: bool = False


@dataclass(frozen=True)
class Description:
    """A robot: its links and joints in the order of the file. ``source`` names the file or text, for messages.

    ``folder`` is the folder of that file and ``package_dirs`` the folders of its packages, in which its meshes are searched.
    ``srdf`` is its semantic description, with names of this robot only; empty if none was given. ``left_out`` lists the faulty
    parts that were omitted.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    source: str = ""
    text: str = field(default="", repr=False)
    folder: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    srdf: Srdf = field(default=Srdf(), repr=False)
    left_out: tuple[LeftOut, ...] = field(default=(), repr=False)
