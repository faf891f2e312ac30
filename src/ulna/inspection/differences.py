"""Pairs the joints and links of two robots, and compares the pairs."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import angle_between, rpy_from_matrix
from ulna.description.robot_description import Body, Description, Joint, JointType, Link, Mimic
from ulna.description.shapes import ConvexMesh, Mesh, Shape, UnknownShape
from ulna.description.structure import joints_from_root
from ulna.inspection.result import Difference, Tolerances
from ulna.robot import Robot

KINDS = ("link", "joint", "order", "type", "parent", "origin", "axis", "limits", "mimic", "pose", "visual", "collision")
_WITH_AXIS = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC, JointType.PLANAR)


@dataclass(frozen=True)
class Matching:
    """Pairs of joints and of link names, ``by`` "name" or "order", and the links in which poses are compared."""

    by: str
    joints: tuple[tuple[Joint, Joint], ...]
    links: tuple[tuple[str, str], ...]
    frames: tuple[str, str]


def match(a: Robot, b: Robot) -> Matching:
    """Match by name, or by order if fewer than half of the smaller robot's moving joints share names.

    A link whose name the other robot lacks corresponds to the child of the matching joint. The root corresponds to the root, the
    tip to the tip.
    """
    moving_a, moving_b = _moving(a.description), _moving(b.description)
    others = {joint.name: joint for joint in b.description.joints}
    shared = sum(joint.name in others for joint in moving_a)
    by_name = 2 * shared >= min(len(moving_a), len(moving_b))
    if by_name:
        joints = [(joint, others[joint.name]) for joint in a.description.joints if joint.name in others]
    else:
        joints = list(zip(moving_a, moving_b, strict=False))
    named = [(name, name) for name in a.link_names if name in b.link_names]
    carried = [(one.child, other.child) for one, other in joints]
    ends = [(a.base, b.base), *([(a.tip, b.tip)] if a.tip is not None and b.tip is not None else [])]
    links = dict(_first_of_each([*named, *carried, *ends] if by_name else [*carried, *named, *ends]))
    ordered = tuple((name, links[name]) for name in a.link_names if name in links)
    frames = next((pair for pair in ordered if pair[0] == a.base or pair[1] == b.base), (a.base, b.base))
    return Matching("name" if by_name else "order", tuple(joints), ordered, frames)


def _first_of_each(pairs: list[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """The pairs without a member that appears in an earlier pair."""
    taken_a, taken_b = set(), set()
    for one, other in pairs:
        if one not in taken_a and other not in taken_b:
            taken_a.add(one)
            taken_b.add(other)
            yield one, other


def _moving(description: Description) -> list[Joint]:
    return [joint for joint in joints_from_root(description) if joint.type != JointType.FIXED and joint.mimic is None]


def joint_differences(one: Joint, other: Joint, matching: Matching, tolerances: Tolerances) -> Iterator[Difference]:
    """Differences between two corresponding joints; origins and axes only if their parent links correspond too."""
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
    if _poses_differ(one.origin, other.origin, tolerances):
        yield Difference("origin", one.name, _place_words(one.origin), _place_words(other.origin))
    if one.type in _WITH_AXIS and other.type in _WITH_AXIS:
        axis_a, axis_b = one.origin[:3, :3] @ one.axis, other.origin[:3, :3] @ other.axis
        angle = float(np.arctan2(np.linalg.norm(np.cross(axis_a, axis_b)), axis_a @ axis_b))
        if angle > tolerances.rotation:
            yield Difference("axis", one.name, f"({_words(axis_a)}) in {one.parent}", f"({_words(axis_b)}) in {other.parent}")


def body_differences(one: Link, other: Link, tolerances: Tolerances) -> Iterator[Difference]:
    """Differences between the shapes of two links: their number, or kind, size and place of each. Colors do not count."""
    for kind in ("visual", "collision"):
        bodies_a, bodies_b = getattr(one, f"{kind}s"), getattr(other, f"{kind}s")
        if len(bodies_a) != len(bodies_b):
            yield Difference(kind, one.name, _count(bodies_a), _count(bodies_b))
            continue
        for k, (body_a, body_b) in enumerate(zip(bodies_a, bodies_b, strict=True), start=1):
            where = one.name if len(bodies_a) == 1 else f"{one.name}, shape {k}"
            if not _shapes_equal(body_a.shape, body_b.shape, tolerances.position):
                yield Difference(kind, where, _shape_words(body_a.shape), _shape_words(body_b.shape))
            if _poses_differ(body_a.pose, body_b.pose, tolerances):
                yield Difference(kind, where, _place_words(body_a.pose), _place_words(body_b.pose))


def _poses_differ(T_a: NDArray[np.float64], T_b: NDArray[np.float64], tolerances: Tolerances) -> bool:
    away = np.linalg.norm((T_a - T_b)[:3, 3])
    return bool(away > tolerances.position or angle_between(T_a, T_b) > tolerances.rotation)


def _shapes_equal(one: Shape, other: Shape, tolerance: float) -> bool:
    if type(one) is not type(other):
        return False
    pairs = zip(asdict(one).values(), asdict(other).values(), strict=True)
    return all(a == b if isinstance(a, str) else _numbers_close(a, b, tolerance) for a, b in pairs)


def _numbers_close(one, other, tolerance: float) -> bool:
    return np.shape(one) == np.shape(other) and np.allclose(one, other, rtol=0, atol=tolerance)


def _shape_words(shape: Shape) -> str:
    if isinstance(shape, ConvexMesh):
        return f"convex mesh of {len(shape.vertices)} vertices"
    if isinstance(shape, UnknownShape):
        return shape.kind
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
