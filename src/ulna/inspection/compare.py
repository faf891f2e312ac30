"""Compares two robots, part by part and pose by pose."""

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_number
from ulna.description.pose import angle_between, inverse
from ulna.errors import InputError, did_you_mean
from ulna.inspection.differences import KINDS, Matching, body_differences, joint_differences, match
from ulna.inspection.result import Comparison, Difference, PoseDifference, Tolerances
from ulna.kinematics.sample import usual_range
from ulna.robot import Robot

N_CONFIGURATIONS = 1000
Array = NDArray[np.float64]


def compare(
    a: Robot,
    b: Robot,
    *,
    ignore: Iterable[str] = (),
    position_tolerance: float = 1e-6,
    rotation_tolerance: float = 1e-6,
    limit_tolerance: float = 1e-6,
) -> Comparison:
    """Compare two descriptions of one robot: names, order, types, limits, axes, poses and shapes.

    Joints are matched by name, or by their order from the root if fewer than half of the moving ones share a name. The poses of
    all corresponding links are compared at 1000 random configurations.

    Args:
        a: One robot.
        b: The other.
        ignore: Kinds of differences that do not count: ``"link"``, ``"joint"``, ``"order"``, ``"type"``, ``"parent"``,
            ``"origin"``, ``"axis"``, ``"limits"``, ``"mimic"``, ``"pose"``, ``"visual"``, ``"collision"``.
        position_tolerance: Distances that count as none [m].
        rotation_tolerance: Angles that count as none [rad].
        limit_tolerance: Differences of limits that count as none [rad or m, rad/s or m/s, Nm or N].

    Returns:
        A ``Comparison``; ``print`` it. ``same`` is True if nothing differs.

    Raises:
        InputError: An argument is not a robot, a tolerance is negative, or a kind to ignore is unknown.

    Example:
        >>> from ulna import load, pose
        >>> panda = load("panda")
        >>> print(compare(panda, panda.with_tool(pose((0, 0, 0.1))), ignore=["link"]))
        panda | panda: 1 difference
        joint tool_joint: missing | defined
    """
    for name, robot in (("a", a), ("b", b)):
        if not isinstance(robot, Robot):
            raise InputError(name, f"{robot!r}; a Robot is expected, as from ulna.load")
    ignored = _kinds(ignore)
    numbers = {"position": position_tolerance, "rotation": rotation_tolerance, "limit": limit_tolerance}
    for name, value in numbers.items():
        as_number(f"{name}_tolerance", value, 0.0, "a number of at least 0", most=math.inf)
    tolerances, matching = Tolerances(**numbers), match(a, b)
    poses = pose_differences(a, b, matching)
    found = _differences(a, b, matching, poses, tolerances)
    return Comparison(
        name_a=a.name,
        name_b=b.name,
        differences=tuple(difference for difference in found if difference.kind not in ignored),
        poses=poses,
        matched_by=matching.by,
        frame_a=matching.frames[0],
        frame_b=matching.frames[1],
        n_configurations=N_CONFIGURATIONS,
        tolerances=tolerances,
    )


def _kinds(ignore: Iterable[str]) -> set[str]:
    kinds = [ignore] if isinstance(ignore, str) else list(ignore)
    for kind in kinds:
        if kind not in KINDS:
            raise InputError("ignore", f"{kind!r} is not a kind of difference{did_you_mean(str(kind), KINDS, most=len(KINDS))}")
    return set(kinds)


def _differences(
    a: Robot, b: Robot, matching: Matching, poses: tuple[PoseDifference, ...], tolerances: Tolerances
) -> Iterator[Difference]:
    joints = [(one.name, other.name) for one, other in matching.joints]
    yield from _names("link", list(a.link_names), list(b.link_names), list(matching.links))
    all_a, all_b = ([joint.name for joint in robot.description.joints] for robot in (a, b))
    yield from _names("joint", all_a, all_b, joints)
    yield from _order("links", a.link_names, b.link_names, matching.links)
    yield from _order("q", a.joint_names, b.joint_names, joints)
    for one, other in matching.joints:
        yield from joint_differences(one, other, matching, tolerances)
    for pose in poses:
        if pose.position > tolerances.position or pose.rotation > tolerances.rotation:
            apart = f"up to {pose.position:.3g} m, {pose.rotation:.3g} rad away"
            yield Difference("pose", pose.link_a, f"in {matching.frames[0]}", apart)
    links_a, links_b = ({link.name: link for link in robot.description.links} for robot in (a, b))
    for name_a, name_b in matching.links:
        yield from body_differences(links_a[name_a], links_b[name_b], tolerances)


def _names(kind: str, names_a: list[str], names_b: list[str], pairs: list[tuple[str, str]]) -> Iterator[Difference]:
    """Corresponding parts with different names, and parts that only one robot has."""
    partners, taken = dict(pairs), {name for _, name in pairs}
    for name in names_a:
        partner = partners.get(name)
        if partner != name:
            yield Difference(kind, name, "defined" if partner is None else name, partner or "missing")
    for name in names_b:
        if name not in taken:
            yield Difference(kind, name, "missing", "defined")


def _order(where: str, names_a: Iterable[str], names_b: Iterable[str], pairs: Iterable[tuple[str, str]]) -> Iterator[Difference]:
    """The first place where corresponding parts have another order, if any."""
    partners = dict(pairs)
    order_b = [name for name in names_b if name in partners.values()]
    order_a = [name for name in names_a if partners.get(name) in order_b]
    for name_a, name_b in zip(order_a, order_b, strict=False):
        if partners[name_a] != name_b:
            yield Difference("order", where, f"... {name_a} ...", f"... {name_b} ...")
            return


def pose_differences(a: Robot, b: Robot, matching: Matching) -> tuple[PoseDifference, ...]:
    """The largest pose differences of each pair of links. Joints without a partner stay at home."""
    q_a, q_b = _configurations(a, b, matching)
    names_a, names_b = ([pair[side] for pair in matching.links] for side in (0, 1))
    T_a, T_b = _poses(a, q_a, matching.frames[0], names_a), _poses(b, q_b, matching.frames[1], names_b)
    positions = np.linalg.norm((T_a - T_b)[..., :3, 3], axis=-1).max(axis=0)
    rotations = angle_between(T_a, T_b).max(axis=0)
    rows = zip(names_a, names_b, positions.tolist(), rotations.tolist(), strict=True)
    return tuple(PoseDifference(*row) for row in rows)


def _poses(robot: Robot, q: Array, frame: str, links: list[str]) -> Array:
    """T_frame_link, shape (n, n_links, 4, 4)."""
    T = robot.link_poses(q)
    at = {name: k for k, name in enumerate(robot.link_names)}
    return inverse(T[:, at[frame]])[:, None] @ T[:, [at[name] for name in links]]


def _configurations(a: Robot, b: Robot, matching: Matching) -> tuple[Array, Array]:
    q_a, q_b = (np.tile(robot.home, (N_CONFIGURATIONS, 1)) for robot in (a, b))
    slices_a, slices_b = (dict(zip(robot.joint_names, robot.joint_slices, strict=True)) for robot in (a, b))
    rng = np.random.default_rng(0)
    for one, other in matching.joints:
        columns_a, columns_b = slices_a.get(one.name), slices_b.get(other.name)
        if columns_a is None or columns_b is None or one.type != other.type:
            continue
        lower = np.maximum(a.lower[columns_a], b.lower[columns_b])
        upper = np.minimum(a.upper[columns_a], b.upper[columns_b])
        apart = lower > upper
        low, high = usual_range(np.where(apart, a.lower[columns_a], lower), np.where(apart, a.upper[columns_a], upper))
        q_a[:, columns_a] = q_b[:, columns_b] = rng.uniform(low, high, (N_CONFIGURATIONS, len(low)))
    return q_a, q_b
