"""The limits of a motion: numbers, the name of an arm, or a file ``joint_limits.yaml`` as MoveIt has it.

Of the file max_velocity, max_acceleration, max_jerk and has_..._limits of each joint are read, also with the tags !degrees and
!radians before a number, which the files of some arms have. Positions, which the description limits, and scaling factors are not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.file_bytes import file_bytes
from ulna.description.yaml_text import yaml_value
from ulna.errors import DescriptionError, FileError, InputError, UnknownNameError, cited, listed
from ulna.planning.arm_limits import ARMS, ArmLimits
from ulna.planning.timing import Limits

Array = NDArray[np.float64]
LARGEST = 1e9  # of a limit [1/s^n]: above, the times are rounding
_MOST_BYTES = 1_000_000  # of a file
FRANKA = "franka"  # the Panda or the FR3, by the names of the joints


def limits_of(limits: str | Path, names: Sequence[str]) -> ArmLimits:
    """The limits of an arm by its name, or of a file.

    Args:
        limits: A name in ``ARMS``, "franka" (the FR3 where the names of the joints say so, else the Panda), or a file ``*.yaml``.
        names: Those of the entries of q.

    Raises:
        UnknownNameError: There is no such name, and it is no ``*.yaml``.
        InputError: The arm has another number of joints.
        FileError, DescriptionError: The file cannot be read, or is not a file of joint limits.
    """
    if not isinstance(limits, str | Path):
        raise InputError("limits", f"{cited(limits)}; the name of an arm or a file joint_limits.yaml is expected")
    if Path(limits).suffix in {".yaml", ".yml"}:
        return read_joint_limits(Path(limits), names)
    name = str(limits)
    if name == FRANKA:
        name = "fr3" if any("fr3" in joint.lower() for joint in names) else "panda"
    if name not in ARMS:
        raise UnknownNameError("set of limits", name, (FRANKA, *ARMS), "; a file has to end in .yaml")
    if len(ARMS[name].velocity) != len(names):
        few, many = len(ARMS[name].velocity), f"{len(names)} ({', '.join(names)})"
        raise InputError("limits", f"{name} has {few} joints, the robot has {many}; a .yaml file names its joints")
    return ARMS[name]


def velocities_of(arm: ArmLimits, described: Array) -> Array:
    """The velocities of an arm, and where it states none those of the description, shape (n,) [rad/s or m/s]."""
    return np.where(np.isnan(arm.velocity), described, arm.velocity)


def as_motion_limits(
    names: Sequence[str],
    own_velocity: Array,
    velocity: ArrayLike | None,
    acceleration: ArrayLike | None,
    jerk: ArrayLike | None,
    limits: str | Path | None,
) -> Limits:
    """The limits of a motion: what is given as numbers, then what ``limits`` states, then the velocities of the description.

    Raises:
        InputError: No acceleration is given, one of them is not above 0, or the description allows a joint no velocity.
        UnknownNameError, FileError, DescriptionError: As for ``limits_of``.
    """
    arm = None if limits is None else limits_of(limits, names)
    if velocity is None:
        known = own_velocity if arm is None else velocities_of(arm, own_velocity)
        if not known.all():
            still = ", ".join(repr(name) for name, most in zip(names, known, strict=True) if not most)
            raise InputError(
                "velocity", f"the description allows {still} a velocity of 0, so no motion has times; give velocity="
            )
        velocity = known
    if acceleration is None:
        if arm is None or arm.acceleration is None:
            missing = "none is given" if arm is None else f"{limits} states none ({arm.source})"
            raise InputError("acceleration", f"{missing}; give acceleration=")
        acceleration = arm.acceleration
    if jerk is None and arm is not None:
        jerk = arm.jerk
    n = len(names)
    return Limits(
        as_limits("velocity", velocity, n, may_be_infinite=True),
        as_limits("acceleration", acceleration, n),
        None if jerk is None else as_limits("jerk", jerk, n),
    )


def as_limits(name: str, given: ArrayLike, n_dof: int, *, may_be_infinite: bool = False) -> Array:
    """Limits as n_dof numbers above 0.

    Raises:
        InputError: They are neither one such number nor n_dof, or above 1e9; a velocity may be infinite.
    """
    limits = as_floats(name, given)
    if limits.shape not in {(), (n_dof,)} or not (limits > 0).all():
        raise InputError(name, f"{given!r}; a number above 0, or {n_dof} of them, is expected")
    beyond = limits > LARGEST
    if (beyond & (limits < np.inf) if may_be_infinite else beyond).any():
        raise InputError(name, f"{given!r}; at most {LARGEST:g} is expected{', or inf' if may_be_infinite else ''}")
    return np.full(n_dof, limits)


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
        has = listed([cited(str(joint))[1:-1] for joint in joints]) or "none"
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
    try:
        document = yaml_value(text, {"!degrees": lambda angle: math.radians(float(angle)), "!radians": float})
    except ValueError as error:
        raise DescriptionError(f"not YAML ({error})", source) from None
    joints = document.get("joint_limits") if isinstance(document, dict) else None
    if not isinstance(joints, dict):
        raise DescriptionError("has no mapping joint_limits", source)
    return joints


def _limit(joint: Any, name: str, quantity: str, source: str) -> float:
    """A limit of a joint; NaN if it has none."""
    if not isinstance(joint, dict):
        raise DescriptionError(f"{name}: a mapping is expected, not {cited(joint)}", source)
    value, key = joint.get(f"max_{quantity}"), f"max_{quantity}"
    if not joint.get(f"has_{quantity}_limits", value is not None):
        return math.nan
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value <= LARGEST:
        raise DescriptionError(f"{name}: {key} is {cited(value)}; a number above 0 and up to {LARGEST:g} is expected", source)
    return float(value)


def _all_or_none(limits: Array, names: Sequence[str], quantity: str, source: str) -> Array | None:
    """The limits of a quantity, or None if no joint has one."""
    missing = np.isnan(limits)
    if missing.any() and not missing.all():
        without = ", ".join(name for name, none in zip(names, missing, strict=True) if none)
        raise DescriptionError(f"limits the {quantity} of some joints, but not of {without}", source)
    return None if missing.all() else limits
