"""Lists the kinematic tree depth first: every link with its joint and its depth. Used by the page."""

from collections import defaultdict
from typing import NamedTuple

from ulna.description.robot_description import Joint
from ulna.robot import Robot


class Branch(NamedTuple):
    """A line of the tree: its depth, the link, and the joint that carries it (None for the root)."""

    depth: int
    link: str
    joint: Joint | None


def outline(robot: Robot) -> list[Branch]:
    """The links depth first, in the order of the description."""
    carried: defaultdict[str, list[Joint]] = defaultdict(list)
    for joint in robot.description.joints:
        carried[joint.parent].append(joint)
    lines, waiting = [], [Branch(0, robot.base, None)]
    while waiting:
        line = waiting.pop()
        lines.append(line)
        waiting += [Branch(line.depth + 1, joint.child, joint) for joint in reversed(carried[line.link])]
    return lines
