"""Where a robot is, how it moves, and how it gets there."""

import numpy as np
from numpy.typing import NDArray

from ulna.answers.entries import Q_KEYS, data_of_q, entries_of_q
from ulna.answers.plain import Data
from ulna.ik.result import IKResult
from ulna.model.pose import quaternion_from_matrix, rpy_from_matrix
from ulna.robot import Robot

Array = NDArray[np.float64]

GEOMETRIC_ROWS = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
ANALYTICAL_ROWS = ("x", "y", "z", "roll", "pitch", "yaw")
POSE_KEYS = f"{Q_KEYS}; base; link; position; rpy; wxyz; matrix: 4x4, T_base_link."
JACOBIAN_KEYS = (
    f"{Q_KEYS}; base; link; kind: geometric or analytical; expressed_in: base, link or spatial, null if analytical; "
    "rows and columns: their labels; jacobian: 6 rows."
)
IK_KEYS = (
    "robot; base; link; target: matrix, 4x4, and orientation, given or home; method; status; success; joints; units; q; lower; "
    "upper; position_error; rotation_error; residual: x, y, z, rx, ry, rz in the target's axes; task; iterations; starts: number "
    "of the start that led to q; reason; reach_excess [m]; limit_excess by joint; trace: rows of position error, rotation error, "
    "largest joint step, damping, or null."
)


def pose_data(robot: Robot, q: Array, link: str, T: Array) -> Data:
    """The pose of a link; see ``POSE_KEYS``."""
    return {
        **data_of_q(robot, q),
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
        **data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "kind": "analytical" if expressed_in is None else "geometric",
        "expressed_in": expressed_in,
        "rows": ANALYTICAL_ROWS if expressed_in is None else GEOMETRIC_ROWS,
        "columns": [entry.name for entry in entries_of_q(robot)],
        "jacobian": J,
    }


def ik_data(robot: Robot, link: str, T: Array, orientation: str, asked: dict[str, str], result: IKResult) -> Data:
    """What a search found; see ``IK_KEYS``."""
    return {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "target": {"matrix": T, "orientation": orientation},
        **asked,
        "status": str(result.status),
        "success": bool(result.success),
        "joints": [entry.name for entry in entries_of_q(robot)],
        "units": [entry.unit for entry in entries_of_q(robot)],
        "q": result.q,
        "lower": robot.lower,
        "upper": robot.upper,
        "position_error": float(result.position_error),
        "rotation_error": float(result.rotation_error),
        "residual": result.residual,
        "iterations": int(result.iterations),
        "starts": int(result.starts),
        "reason": result.reason,
        "reach_excess": float(result.reach_excess),
        "limit_excess": result.limit_excess,
        "trace": result.trace if result.has_trace else None,
    }
