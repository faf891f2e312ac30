"""Names the entries of q and their units."""

from typing import NamedTuple

from ulna.description.robot_description import JointType
from ulna.robot import Robot


class Coordinate(NamedTuple):
    """One entry of q or of a similar list of numbers: its name and its unit."""

    name: str
    unit: str
    type: str = ""

    @property
    def effort_unit(self) -> str:
        """The unit of the joint's torque, or of its force if it is a slide."""
        return "N" if self.unit == "m" else "Nm"


_PARTS = {
    JointType.PRISMATIC: (("", "m"),),
    JointType.PLANAR: ((".x", "m"), (".y", "m"), (".theta", "rad")),
    JointType.FLOATING: ((".x", "m"), (".y", "m"), (".z", "m"), (".roll", "rad"), (".pitch", "rad"), (".yaw", "rad")),
}


def coordinates_of(robot: Robot) -> list[Coordinate]:
    """The name, unit and joint type of each entry of q, in order."""
    types = {joint.name: joint.type for joint in robot.description.joints}
    return [
        Coordinate(name + part, unit, types[name].value)
        for name in robot.joint_names
        for part, unit in _PARTS.get(types[name], (("", "rad"),))
    ]
