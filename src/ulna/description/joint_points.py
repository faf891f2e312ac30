"""Reads timed joint points, messages of ROS and plans of MoveIt, from YAML or JSON.

A message is a ``trajectory_msgs/JointTrajectory``, or anything that contains one, such as a ``moveit_msgs/RobotTrajectory``, a
``DisplayTrajectory`` or the goal of a controller. The names of ROS 1 and ROS 2 are both read.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.file_bytes import file_bytes, json_value
from ulna.description.yaml_text import yaml_value
from ulna.errors import DescriptionError, FileError, cited, count_of, reason_of

Array = NDArray[np.float64]
ENDINGS = {".yaml", ".yml", ".json"}
_LONGEST = {".json": 100_000_000, ".yaml": 4_000_000, ".yml": 4_000_000}  # bytes
_MAX_NODES = 30_000  # of a YAML text; each node takes 50 us
_DEEPEST = 8  # maximum depth of a message within others
_OTHER_JOINTS = "multi_dof_joint_trajectory"  # its points are poses
_LARGEST = 1e9  # largest number
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsec", "nsecs")


class JointPoints(NamedTuple):
    """Timed joint points.

    Attributes:
        names: The names of the k joints.
        times: [s], shape (n,), n >= 1.
        q: Positions [rad or m], shape (n, k).
        qd: Velocities [rad/s or m/s], shape (n, k); NaN in points without velocities.
        qdd: Accelerations [rad/s^2 or m/s^2], shape (n, k); NaN in points without accelerations.
    """

    names: tuple[str, ...]
    times: Array
    q: Array
    qd: Array
    qdd: Array


def read_joint_points(path: Path) -> JointPoints:
    """Read the points of a YAML or JSON file.

    Raises:
        FileError: The file cannot be read, or is too long.
        DescriptionError: It has no such message, several, or an incomplete one.
    """
    ending, source = path.suffix.lower(), str(path)
    try:
        content = file_bytes(path, _LONGEST[ending])
    except OSError as error:
        raise FileError(source, reason_of(error)) from None
    if len(content) > _LONGEST[ending]:
        other = "" if ending == ".json" else "; JSON or CSV may be longer"
        raise FileError(source, f"has more than {_LONGEST[ending] // 1_000_000} MB{other}")
    try:
        document = _document(content, ending)
    except ValueError as error:
        raise DescriptionError(f"not {ending[1:].upper()} ({error})", source) from None
    except MemoryError:
        raise FileError(source, "cannot be read: out of memory") from None
    found = list(_messages(document, source, _DEEPEST))
    if not found:
        has_path = isinstance(document, Mapping) and isinstance(document.get("path"), list)
        remedy = "; it has a path without times, to which robot.trajectory(path, ...) gives times" if has_path else ""
        raise DescriptionError(f"has no message with joint_names and points{remedy}", source)
    if len(found) > 1:
        raise DescriptionError(f"has {len(found)} trajectories; keep one of them", source)
    return _points(found[0], source)


def _document(content: bytes, ending: str) -> Any:
    """The value of a text; YAML must be one document, which may end with --- as ROS tools print."""
    if ending == ".json":
        return json_value(content)
    text = content.decode("utf-8-sig", errors="replace")
    parts = [part for part in re.split(r"^---[ \t]*$", text, flags=re.MULTILINE) if part.strip()]
    if len(parts) > 1:
        raise ValueError(f"it has {len(parts)} messages, between lines of ---; keep one of them")
    return yaml_value(parts[0] if parts else "", {}, _MAX_NODES)


def _messages(value: Any, source: str, depth: int) -> Iterator[Mapping[str, Any]]:
    """Each mapping that has joint_names and points."""
    if depth == 0:
        return
    if isinstance(value, list):
        for each in value[:1000]:
            yield from _messages(each, source, depth - 1)
    elif isinstance(value, Mapping):
        if "joint_names" in value and "points" in value:
            yield value
            return
        for key, each in value.items():
            if key != _OTHER_JOINTS:
                yield from _messages(each, source, depth - 1)
            elif isinstance(each, Mapping) and each.get("points"):
                raise DescriptionError(f"has points of {_OTHER_JOINTS}, which are poses; those are not read", source)


def _points(message: Mapping[str, Any], source: str) -> JointPoints:
    names, points = message["joint_names"], message["points"]
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise DescriptionError(f"joint_names is {cited(names)}; a list of names is expected", source)
    name, count = Counter(names).most_common(1)[0]
    if count > 1:
        raise DescriptionError(f"joint_names has {cited(name)} twice", source)
    if not isinstance(points, list) or not points:
        raise DescriptionError(f"points is {cited(points)}; a list of at least one point is expected", source)
    k, times = len(names), np.empty(len(points))
    rows = [np.full((len(points), k), np.nan) for _ in range(3)]
    for number, point in enumerate(points):
        where = f"point {number}"
        if not isinstance(point, Mapping):
            raise DescriptionError(f"{where} is {cited(point)}; a mapping with positions and time_from_start is expected", source)
        times[number] = _time(point.get("time_from_start"), f"{where}: time_from_start", source)
        for row, kind in zip(rows, ("positions", "velocities", "accelerations"), strict=True):
            values = _numbers(point.get(kind), k, f"{where}: {kind}", source)
            if values is not None:
                row[number] = values
        if np.isnan(rows[0][number]).any():
            raise DescriptionError(f"{where} has no positions", source)
    return JointPoints(tuple(names), times, *rows)


def _numbers(values: Any, k: int, where: str, source: str) -> Array | None:
    """The numbers of a list of k; None for a missing or empty list."""
    if values is None or (isinstance(values, list) and not values):
        return None
    if not isinstance(values, list):
        raise DescriptionError(f"{where} is {cited(values)}; a list of numbers is expected", source)
    if "..." in values:
        raise DescriptionError(f"{where} is cut short by '...'; ros2 topic echo --full-length prints all of it", source)
    if len(values) != k:
        raise DescriptionError(
            f"{where} has {count_of(len(values), 'number')}, and there are {count_of(k, 'joint name')}", source
        )
    return np.array([_number(value, where, source) for value in values])


def _number(value: Any, where: str, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _LARGEST:
        raise DescriptionError(f"{where} has {cited(value)}; a finite number is expected, at most {_LARGEST:g}", source)
    return float(value)


def _time(value: Any, where: str, source: str) -> float:
    """The seconds of a duration: a mapping of ROS 1 or ROS 2, or a number."""
    if not isinstance(value, Mapping):
        return _number(value, where, source)
    whole, parts = (next((value[key] for key in keys if key in value), None) for keys in (_SECONDS, _NANOSECONDS))
    if whole is None:
        raise DescriptionError(f"{where} is {cited(value)}; sec and nanosec are expected", source)
    return _number(whole, where, source) + 1e-9 * _number(0 if parts is None else parts, where, source)


def is_message(path: Path) -> bool:
    """Whether the extension of a file is that of YAML or JSON."""
    return path.suffix.lower() in ENDINGS
