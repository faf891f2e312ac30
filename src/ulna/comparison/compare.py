"""Compares two robots, part by part and pose by pose. Used by ``ulna.compare`` and ``ulna compare``."""

from collections.abc import Iterable, Iterator

from ulna.comparison.matching import Matching, match
from ulna.comparison.parts import body_differences, joint_differences
from ulna.comparison.poses import N_CONFIGURATIONS, pose_differences
from ulna.comparison.result import KINDS, Comparison, Difference, PoseDifference, Tolerances
from ulna.errors import InputError, did_you_mean
from ulna.robot import Robot


def compare(
    a: Robot,
    b: Robot,
    *,
    ignore: Iterable[str] = (),
    position_tolerance: float = 1e-6,
    rotation_tolerance: float = 1e-6,
    limit_tolerance: float = 1e-6,
) -> Comparison:
    """How two descriptions of one robot differ: in names, order, types, limits, axes, poses and shapes.

    Joints are matched by name; by their order from the root if fewer than half of the moving ones share a name. The poses of
    all links that correspond are compared at 1000 random configurations.

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
        InputError: An argument is not a robot, a tolerance is negative, or a kind to ignore is not known.

    Example:
        >>> from ulna import load, pose
        >>> panda = load("panda")
        >>> print(compare(panda, panda.with_tool(pose((0, 0, 0.1))), ignore=["link"]))
        panda | panda: 1 difference
        joint tool_joint: missing | defined
    """
    for name, robot in (("a", a), ("b", b)):
        if not isinstance(robot, Robot):
            raise InputError(name, f"{robot!r}; a Robot is expected, as ulna.load makes one")
    ignored = _kinds(ignore)
    numbers = {"position": position_tolerance, "rotation": rotation_tolerance, "limit": limit_tolerance}
    for name, value in numbers.items():
        if not (isinstance(value, float | int) and value >= 0):
            raise InputError(f"{name}_tolerance", f"{value!r}; a number of at least 0 is expected")
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
    """Whether corresponding parts have another order; the first place where they do."""
    partners = dict(pairs)
    order_b = [name for name in names_b if name in partners.values()]
    order_a = [name for name in names_a if partners.get(name) in order_b]
    for name_a, name_b in zip(order_a, order_b, strict=False):
        if partners[name_a] != name_b:
            yield Difference("order", where, f"... {name_a} ...", f"... {name_b} ...")
            return
