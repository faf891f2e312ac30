"""Reads the tables of arms: kinematics, limits and inertias from public descriptions, and collision shapes of our own.

A file of the folder ``arms`` contains the arms of one maker. Each arm has its joints, one per row, and the shapes that contain
its links. A capsule is a link, the two centers of its ends [m] and its radius [m]; a cylinder is the same and ``"flat"``. A box
is a link and two opposite corners [m]. An inertia is a link, its mass [kg], its center of mass [m], and its tensor [kg m^2],
six numbers in URDF's order. If the tensor's axes are not the link's, their roll, pitch and yaw follow [deg].
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ulna.description.pose import pose
from ulna.description.robot_description import Body, Description, Inertia, Joint, JointType, Limits, Link
from ulna.description.shapes import Box, Capsule, Cylinder
from ulna.description.urdf_writer import write_urdf

Point = list[float]
_ZERO: Point = [0.0, 0.0, 0.0]


class JointRow(NamedTuple):
    """A joint: ``xyz`` [m] and ``rpy`` [deg] give its pose in the parent; a limit is None without a source.

    Positions, velocity and acceleration are in the table's unit of angle and in seconds, the effort in Nm.
    """

    name: str
    type: str
    parent: str
    child: str
    xyz: Point
    rpy: Point
    axis: Point = [1.0, 0.0, 0.0]  # noqa: RUF012 - URDF's default
    range: Point | None = None
    velocity: float | None = None
    effort: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True)
class ArmTable:
    """An arm of the tables.

    Attributes:
        name: Its name for ``ulna.load``.
        maker: Its manufacturer.
        model: The maker's name for it.
        also: Other names for ``ulna.load``.
        payload: The maker's rated payload [kg].
        reach: The maker's stated reach [m].
        source: The public description that the figures come from: repository and commit.
        license: The license of the source.
        files: The files of the source.
        limits_from: The origin of the motion limits, and what the source leaves open.
        shapes_from: The origin of the shapes.
        degrees: Whether positions, velocities and accelerations are in degrees, not in radians.
        start: The home configuration [deg].
        rows: The joints, from the base to the tip.
        shapes: Capsules, cylinders and boxes, as above.
        allowed: Pairs of links whose shapes may touch, although the arm's links do not.
        inertias: The inertias, as above; none if the source has none, or only implausible ones.
        inertias_from: The origin of the inertias if not the source, and their changes.
    """

    name: str
    maker: str
    model: str
    also: list[str]
    payload: float
    reach: float
    source: str
    license: str
    files: str
    limits_from: str
    shapes_from: str
    degrees: bool
    start: Point
    rows: tuple[JointRow, ...]
    shapes: list[list[Any]]
    allowed: tuple[list[str], ...] = ()
    inertias: tuple[list[Any], ...] = ()
    inertias_from: str = ""

    @property
    def file(self) -> str:
        """The name of its document, for messages."""
        return f"{self.name}.urdf"

    @property
    def home(self) -> tuple[float, ...]:
        """The home configuration [rad]."""
        return tuple(np.deg2rad(self.start).tolist())

    @property
    def moving(self) -> Iterator[JointRow]:
        """The moving joints, in order."""
        return (row for row in self.rows if row.type != JointType.FIXED)

    def radians(self, angle: float | None) -> float:
        """An angle of the table, or its rate [rad, rad/s or rad/s^2]; inf for None."""
        return inf if angle is None else float(np.deg2rad(angle)) if self.degrees else angle

    def text(self) -> bytes:
        """The URDF document."""
        return write_urdf(self.description()).encode()

    def semantics(self) -> str | None:
        """The SRDF document, if a pair of links may touch."""
        pairs = "".join(f'<disable_collisions link1="{a}" link2="{b}" reason="Never"/>' for a, b in self.allowed)
        return f'<robot name="{self.name}">{pairs}</robot>' if pairs else None

    def description(self) -> Description:
        """The arm as data."""
        names = [self.rows[0].parent, *(row.child for row in self.rows)]
        inertias = {name: _inertia(*numbers) for name, *numbers in self.inertias}
        links = (Link(name, (), tuple(_bodies(name, self.shapes)), inertia=inertias.get(name)) for name in names)
        return Description(self.name, tuple(links), tuple(map(self._joint, self.rows)))

    def _joint(self, row: JointRow) -> Joint:
        lower, upper = (-inf, inf) if row.range is None else map(self.radians, row.range)
        effort = inf if row.effort is None else row.effort
        limits = Limits(lower, upper, self.radians(row.velocity), effort, self.radians(row.acceleration))
        origin = pose(row.xyz, rpy=np.deg2rad(row.rpy))
        return Joint(row.name, JointType(row.type), row.parent, row.child, origin, np.array(row.axis), limits)


def _inertia(mass: float, center: Point, tensor: Point, rpy: Point = _ZERO) -> Inertia:
    return Inertia.stated(mass, tensor, pose(center, rpy=np.deg2rad(rpy)))


def _bodies(link: str, shapes: list[list[Any]]) -> Iterator[Body]:
    own = [shape for shape in shapes if shape[0] == link]
    for number, (_, first, last, *round_) in enumerate(own, start=1):
        T, way = np.eye(4), np.subtract(last, first)
        T[:3, 3] = np.add(first, last) / 2
        if not round_:
            yield Body(f"box {number}", Box(tuple(way.tolist())), T)
            continue
        radius, *flat = round_
        length = float(np.linalg.norm(way))
        T[:3, :3] = _turn_to(way / length) if length else np.eye(3)
        yield Body(f"{'cylinder' if flat else 'capsule'} {number}", (Cylinder if flat else Capsule)(radius, length), T)


def _turn_to(z: np.ndarray) -> np.ndarray:
    """A rotation whose third column is a given unit vector."""
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


@cache
def arm_tables() -> dict[str, ArmTable]:
    """The arms of all tables by name, without their other names."""
    arms = {}
    for file in sorted(Path(__file__).with_name("arms").glob("*.json")):
        table = json.loads(file.read_bytes())
        for name, arm in table["arms"].items():
            rows = tuple(JointRow(*row) for row in arm.pop("joints"))
            arms[name] = ArmTable(name, table["maker"], rows=rows, **arm)
    return arms
