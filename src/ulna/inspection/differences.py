"""Holds a comparison as frozen data, and compares joints and shapes in pairs."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import angle_between, rpy_from_matrix
from ulna.description.robot_description import Body, Joint, JointType, Link, Mimic
from ulna.description.shapes import ConvexMesh, Mesh, Shape
from ulna.inspection.matching import Matching

KINDS = ("link", "joint", "order", "type", "parent", "origin", "axis", "limits", "mimic", "pose", "visual", "collision")
_WITH_AXIS = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC, JointType.PLANAR)


@dataclass(frozen=True)
class Difference:
    """One thing that differs. ``kind`` is one of ``KINDS``, ``where`` a joint or a link, ``a`` and ``b`` what each has there."""

    kind: str
    where: str
    a: str
    b: str


@dataclass(frozen=True)
class PoseDifference:
    """The largest distance [m] and angle [rad] between two links that correspond, over random configurations."""

    link_a: str
    link_b: str
    position: float
    rotation: float


@dataclass(frozen=True)
class Tolerances:
    """What still counts as the same: ``position`` [m], ``rotation`` [rad], and ``limit`` in a limit's own unit."""

    position: float = 1e-6
    rotation: float = 1e-6
    limit: float = 1e-6


@dataclass(frozen=True)
class Comparison:
    """How two robots differ: not at all if there are no ``differences``.

    ``poses`` has every pair of links, the same or not. Joints are matched by their names, or ``matched_by`` their order where
    hardly a name is shared. Poses are those in ``frame_a`` and ``frame_b``, at ``n_configurations`` random configurations.
    """

    name_a: str
    name_b: str
    differences: tuple[Difference, ...]
    poses: tuple[PoseDifference, ...]
    matched_by: str
    frame_a: str
    frame_b: str
    n_configurations: int
    tolerances: Tolerances

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    @property
    def max_position_difference(self) -> float:
        """The largest distance [m] between two links that correspond."""
        return max((pose.position for pose in self.poses), default=0.0)

    @property
    def max_rotation_difference(self) -> float:
        """The largest angle [rad] between two links that correspond."""
        return max((pose.rotation for pose in self.poses), default=0.0)

    def __str__(self) -> str:
        lines = [f"{d.kind} {d.where}: {d.a} | {d.b}" for d in self.differences]
        return "\n".join([f"{self.name_a} | {self.name_b}: {len(lines) or 'no'} difference{'s' * (len(lines) != 1)}", *lines])


def joint_differences(one: Joint, other: Joint, matching: Matching, tolerances: Tolerances) -> Iterator[Difference]:
    """What differs between two joints that correspond. Origins and axes, if their parent links correspond too."""
    name = one.name
    if one.type != other.type:
        yield Difference("type", name, one.type.value, other.type.value)
    if (one.parent, other.parent) in matching.links:
        yield from _frame_differences(one, other, tolerances)
    elif matching.by == "name":
        yield Difference("parent", name, one.parent, other.parent)
    for key, limit in asdict(one.limits).items():
        partner = getattr(other.limits, key)
        if limit != partner and not abs(limit - partner) <= tolerances.limit:
            yield Difference("limits", f"{name} {key}", f"{limit:.9g}", f"{partner:.9g}")
    if one.mimic != other.mimic:
        yield Difference("mimic", name, _mimic_words(one.mimic), _mimic_words(other.mimic))


def _frame_differences(one: Joint, other: Joint, tolerances: Tolerances) -> Iterator[Difference]:
    if _apart(one.origin, other.origin, tolerances):
        yield Difference("origin", one.name, _place_words(one.origin), _place_words(other.origin))
    if one.type in _WITH_AXIS and other.type in _WITH_AXIS:
        axis_a, axis_b = one.origin[:3, :3] @ one.axis, other.origin[:3, :3] @ other.axis
        angle = float(np.arctan2(np.linalg.norm(np.cross(axis_a, axis_b)), axis_a @ axis_b))
        if angle > tolerances.rotation:
            yield Difference("axis", one.name, f"({_words(axis_a)}) in {one.parent}", f"({_words(axis_b)}) in {other.parent}")


def body_differences(one: Link, other: Link, tolerances: Tolerances) -> Iterator[Difference]:
    """Which shapes of two links differ: in their number, else each in kind, measures and place. Colours do not count."""
    for kind in ("visual", "collision"):
        bodies_a, bodies_b = getattr(one, f"{kind}s"), getattr(other, f"{kind}s")
        if len(bodies_a) != len(bodies_b):
            yield Difference(kind, one.name, _count(bodies_a), _count(bodies_b))
            continue
        for k, (body_a, body_b) in enumerate(zip(bodies_a, bodies_b, strict=True), start=1):
            where = one.name if len(bodies_a) == 1 else f"{one.name}, shape {k}"
            if not _alike(body_a.shape, body_b.shape, tolerances.position):
                yield Difference(kind, where, _shape_words(body_a.shape), _shape_words(body_b.shape))
            if _apart(body_a.pose, body_b.pose, tolerances):
                yield Difference(kind, where, _place_words(body_a.pose), _place_words(body_b.pose))


def _apart(T_a: NDArray[np.float64], T_b: NDArray[np.float64], tolerances: Tolerances) -> bool:
    away = np.linalg.norm((T_a - T_b)[:3, 3])
    return bool(away > tolerances.position or angle_between(T_a, T_b) > tolerances.rotation)


def _alike(one: Shape, other: Shape, tolerance: float) -> bool:
    if type(one) is not type(other):
        return False
    pairs = zip(asdict(one).values(), asdict(other).values(), strict=True)
    return all(a == b if isinstance(a, str) else _near(a, b, tolerance) for a, b in pairs)


def _near(one, other, tolerance: float) -> bool:
    return np.shape(one) == np.shape(other) and np.allclose(one, other, rtol=0, atol=tolerance)


def _shape_words(shape: Shape) -> str:
    if isinstance(shape, ConvexMesh):
        return f"convex mesh of {len(shape.vertices)} vertices"
    if isinstance(shape, Mesh):
        return f"mesh {shape.uri}" + (f", scale ({_words(shape.scale)})" if shape.scale != (1.0, 1.0, 1.0) else "")
    return f"{type(shape).__name__.lower()}, " + ", ".join(f"{key} {_words(np.ravel(m))}" for key, m in asdict(shape).items())


def _place_words(T: NDArray[np.float64]) -> str:
    rpy = rpy_from_matrix(T)
    return f"at ({_words(T[:3, 3])})" + (f", rpy ({_words(rpy)})" if rpy.any() else "")


def _mimic_words(mimic: Mimic | None) -> str:
    return "independent" if mimic is None else f"{mimic.multiplier:g} * {mimic.joint} + {mimic.offset:g}"


def _count(bodies: tuple[Body, ...]) -> str:
    return f"{len(bodies) or 'no'} shape{'s' * (len(bodies) != 1)}"


def _words(values) -> str:
    return ", ".join(f"{value + 0.0:.9g}" for value in values)
