"""Finds the hand of a robot: the default link for robots with several tips."""

from collections.abc import Iterable

from ulna.description.robot_description import Joint, JointType
from ulna.robot.robot import Robot


def hand_link(robot: Robot) -> str:
    """The hand link: the tip of the longest chain, or the link that carries its fingers; ``tool0`` wins ties."""
    carriers = {joint.child: joint for joint in robot.description.joints}
    tip = max(robot.tree.leaves, key=lambda link: (_count_joints(link, carriers, robot), link == "tool0"))
    half = _count_joints(tip, carriers, robot) / 2
    for joint in _joints_to_root(tip, carriers):
        fingers = [one for one in robot.description.joints if one.parent == joint.parent and one.type != JointType.FIXED]
        if len(fingers) > 1 and joint.parent in carriers and _count_joints(joint.parent, carriers, robot) > half:
            return joint.parent
    return tip


def _joints_to_root(link: str, carriers: dict[str, Joint]) -> Iterable[Joint]:
    """The joints from a link up to the root."""
    while link in carriers:
        yield carriers[link]
        link = carriers[link].parent


def _count_joints(link: str, carriers: dict[str, Joint], robot: Robot) -> int:
    """The number of independent joints that move a link."""
    return sum(joint.name in robot.joint_names for joint in _joints_to_root(link, carriers))
