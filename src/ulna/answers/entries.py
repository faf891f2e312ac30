"""The entries of q, named, and what every answer about one q says."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.answers.plain import Data
from ulna.model.description import JointType
from ulna.robot import Robot

Q_KEYS = "robot; q; outside_limits: joints of q beyond their limits"


class Entry(NamedTuple):
    """One entry of q, or of another list of numbers that people write: its name and its unit."""

    name: str
    unit: str
    type: str = ""


_PARTS = {
    JointType.PRISMATIC: (("", "m"),),
    JointType.PLANAR: ((".x", "m"), (".y", "m"), (".theta", "rad")),
    JointType.FLOATING: ((".x", "m"), (".y", "m"), (".z", "m"), (".roll", "rad"), (".pitch", "rad"), (".yaw", "rad")),
}


def entries_of_q(robot: Robot) -> list[Entry]:
    """What each entry of q is, in order."""
    types = {joint.name: joint.type for joint in robot.description.joints}
    return [
        Entry(name + part, unit, types[name].value)
        for name in robot.joint_names
        for part, unit in _PARTS.get(types[name], (("", "rad"),))
    ]


def data_of_q(robot: Robot, q: NDArray[np.float64]) -> Data:
    """The robot, q, and the joints beyond their limits."""
    outside = (q < robot.lower) | (q > robot.upper)
    names = [entry.name for entry, out in zip(entries_of_q(robot), outside, strict=True) if out]
    return {"robot": robot.name, "q": q, "outside_limits": names}
