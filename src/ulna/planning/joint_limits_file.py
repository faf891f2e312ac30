"""Reads MoveIt's ``joint_limits.yaml``: for each joint max_velocity, max_acceleration and max_jerk, and has_..._limits.

The tags !degrees and !radians before a number, which the files of some arms have, are understood. Positions, which the
description limits, and scaling factors are not read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.file_bytes import file_bytes
from ulna.errors import DescriptionError, FileError
from ulna.planning.arm_limits import ArmLimits

_MOST_BYTES = 1_000_000


def read_joint_limits(path: Path, names: Sequence[str]) -> ArmLimits:
    """The limits of the joints called so.

    A joint without a velocity keeps that of its description (NaN here). An acceleration or a jerk is needed of every joint or of
    none; joints that the robot has not are ignored.

    Raises:
        FileError: The file cannot be read.
        DescriptionError: It is not YAML, has no ``joint_limits`` or none of these joints, or a limit is no number above 0.
    """
    try:
        text = file_bytes(path, _MOST_BYTES)
    except OSError as error:
        raise FileError(str(path), error.strerror or str(error)) from None
    if len(text) > _MOST_BYTES:
        raise FileError(str(path), f"has more than {_MOST_BYTES} bytes")
    joints = _joints(text, str(path))
    if not any(name in joints for name in names):
        has = ", ".join(map(str, joints)) or "none"
        raise DescriptionError(f"has none of the joints {', '.join(names)}; it has {has}", str(path))
    velocity, acceleration, jerk = (
        np.array([_limit(joints.get(name) or {}, name, quantity, str(path)) for name in names])
        for quantity in ("velocity", "acceleration", "jerk")
    )
    return ArmLimits(
        velocity,
        _all_or_none(acceleration, names, "acceleration", str(path)),
        _all_or_none(jerk, names, "jerk", str(path)),
        str(path),
    )


def _joints(text: bytes, source: str) -> dict[str, Any]:
    """What the file says of each joint."""
    import yaml  # noqa: PLC0415 - needed only for such a file

    class Loader(yaml.SafeLoader):
        """PyYAML's safe loader, with angles."""

    def add(tag: str, unit: float) -> None:
        Loader.add_constructor(tag, lambda _, node: float(node.value) * unit)

    add("!degrees", math.pi / 180)
    add("!radians", 1.0)
    try:
        document = yaml.load(text, Loader)  # noqa: S506 - it is derived from the safe one
    except (yaml.YAMLError, TypeError, ValueError, RecursionError) as error:
        raise DescriptionError(f"not YAML ({' '.join(str(error).split())})", source) from None
    joints = document.get("joint_limits") if isinstance(document, dict) else None
    if not isinstance(joints, dict):
        raise DescriptionError("has no mapping joint_limits", source)
    return joints


def _limit(joint: Any, name: str, quantity: str, source: str) -> float:
    """A limit of a joint; NaN if it has none."""
    if not isinstance(joint, dict):
        raise DescriptionError(f"{name}: a mapping is expected, not {joint!r}", source)
    value, key = joint.get(f"max_{quantity}"), f"max_{quantity}"
    if not joint.get(f"has_{quantity}_limits", value is not None):
        return math.nan
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise DescriptionError(f"{name}: {key} is {value!r}; a number above 0 is expected", source)
    return float(value)


def _all_or_none(limits: NDArray[np.float64], names: Sequence[str], quantity: str, source: str) -> NDArray[np.float64] | None:
    """The limits of a quantity, or None if no joint has one."""
    missing = np.isnan(limits)
    if missing.any() and not missing.all():
        without = ", ".join(name for name, none in zip(names, missing, strict=True) if none)
        raise DescriptionError(f"limits the {quantity} of some joints, but not of {without}", source)
    return None if missing.all() else limits
