"""Answers as plain data: what ``--json`` prints, and what the tables draw. Metres and radians throughout.

``..._KEYS`` says what the keys mean; ``--help`` shows it.
"""

from dataclasses import asdict, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Report
from ulna.ik.result import IKResult
from ulna.model.description import JointType
from ulna.model.pose import quaternion_from_matrix, rpy_from_matrix
from ulna.robot import Robot

Array = NDArray[np.float64]
Data = dict[str, object]

GEOMETRIC_ROWS = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
ANALYTICAL_ROWS = ("x", "y", "z", "roll", "pitch", "yaw")

INFO_KEYS = (
    "name; base; tip: null if there are several; leaves; n_dof; joints: one for each entry of q, with name, type, lower, upper, "
    "velocity_limit, home, unit; fixed_joints; mimic_joints: name, joint, multiplier, offset; links; collision_shapes: name, "
    "link, kind, and extents, or radius and length, or uri and scale."
)
_Q_KEYS = "robot; q; outside_limits: joints of q beyond their limits"
POSE_KEYS = f"{_Q_KEYS}; base; link; position; rpy; wxyz; matrix: 4x4, T_base_link."
JACOBIAN_KEYS = (
    f"{_Q_KEYS}; base; link; kind: geometric or analytical; expressed_in: base, link or spatial, null if analytical; "
    "rows and columns: their labels; jacobian: 6 rows."
)
IK_KEYS = (
    "robot; base; link; target: matrix, 4x4, and orientation, given or home; method; status; success; joints; units; q; lower; "
    "upper; position_error; rotation_error; iterations."
)
REPORT_KEYS = (
    f"{_Q_KEYS}; in_collision; signed_distance: the least, null if there is nothing to measure to; touching: shapes of the "
    "robot; pairs: name_a of the robot, link, name_b and link_b (null: of the world), signed_distance (negative: overlap), "
    "witness_a and witness_b: the nearest points, normal from a to b."
)
CHECKS_KEYS = "passed; checks: name, figure, bound, passed."


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


def info_data(robot: Robot) -> Data:
    """What a robot is; see ``INFO_KEYS``."""
    joints = robot.description.joints
    numbers = zip(robot.lower, robot.upper, robot.velocity_limits, robot.home, strict=True)
    keys = ("lower", "upper", "velocity_limit", "home")
    return {
        "name": robot.name,
        "base": robot.base,
        "tip": robot.tip,
        "leaves": list(robot.tree.leaves),
        "n_dof": robot.n_dof,
        "joints": [
            {"name": entry.name, "type": entry.type, **dict(zip(keys, row, strict=True)), "unit": entry.unit}
            for entry, row in zip(entries_of_q(robot), numbers, strict=True)
        ],
        "fixed_joints": [j.name for j in joints if j.type == JointType.FIXED],
        "mimic_joints": [{"name": j.name, **asdict(j.mimic)} for j in joints if j.mimic is not None],
        "links": list(robot.link_names),
        "collision_shapes": [
            {"name": body.name, "link": link.name, "kind": type(body.shape).__name__.lower(), **asdict(body.shape)}
            for link in robot.description.links
            for body in link.collisions
        ],
    }


def _data_of_q(robot: Robot, q: Array) -> Data:
    outside = (q < robot.lower) | (q > robot.upper)
    names = [entry.name for entry, out in zip(entries_of_q(robot), outside, strict=True) if out]
    return {"robot": robot.name, "q": q, "outside_limits": names}


def pose_data(robot: Robot, q: Array, link: str, T: Array) -> Data:
    """The pose of a link; see ``POSE_KEYS``."""
    return {
        **_data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "position": T[:3, 3],
        "rpy": rpy_from_matrix(T),
        "wxyz": quaternion_from_matrix(T),
        "matrix": T,
    }


def jacobian_data(robot: Robot, q: Array, link: str, J: Array, expressed_in: str | None) -> Data:
    """A Jacobian with its labels; see ``JACOBIAN_KEYS``. ``expressed_in`` is None for the analytical one."""
    return {
        **_data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "kind": "analytical" if expressed_in is None else "geometric",
        "expressed_in": expressed_in,
        "rows": ANALYTICAL_ROWS if expressed_in is None else GEOMETRIC_ROWS,
        "columns": [entry.name for entry in entries_of_q(robot)],
        "jacobian": J,
    }


def ik_data(robot: Robot, link: str, T: Array, orientation: str, method: str, result: IKResult) -> Data:
    """What a search found; see ``IK_KEYS``."""
    return {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "target": {"matrix": T, "orientation": orientation},
        "method": method,
        "status": str(result.status),
        "success": bool(result.success),
        "joints": [entry.name for entry in entries_of_q(robot)],
        "units": [entry.unit for entry in entries_of_q(robot)],
        "q": result.q,
        "lower": robot.lower,
        "upper": robot.upper,
        "position_error": float(result.position_error),
        "rotation_error": float(result.rotation_error),
        "iterations": int(result.iterations),
    }


def report_data(robot: Robot, q: Array, report: Report, distance: float) -> Data:
    """What a collision check found, and the least distance; see ``REPORT_KEYS``."""
    pairs = [{field.name: getattr(pair, field.name) for field in fields(pair)} for pair in report.pairs]
    verdict = {"in_collision": report.in_collision, "signed_distance": distance, "touching": report.touching}
    return {**_data_of_q(robot, q), **verdict, "pairs": pairs}


def plain(value):
    """Dictionaries, lists, strings and numbers as JSON has them; what is infinite becomes None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
