"""Reads limits of a motion from numbers, an arm's name, a file ``joint_limits.yaml`` or its mapping.

``joint_limits`` describes the keys that are read. Numbers may have the tags !degrees and !radians, as in the files of some arms.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.file_bytes import file_bytes
from ulna.description.structure import Drive
from ulna.description.yaml_text import yaml_value
from ulna.errors import DescriptionError, FileError, InputError, UnknownNameError, cited, count_of, reason_of
from ulna.kinematics.tree import Tree, entry_names
from ulna.planning.arm_limits import ARMS, ArmLimits
from ulna.planning.joint_limits import arm_limits_of
from ulna.planning.positions import PositionLimits
from ulna.planning.timing import Limits

Array = NDArray[np.float64]
GivenLimits = str | Path | Mapping[str, Any]  # the name of an arm, a file, or its content
LARGEST = 1e9  # the maximum of a limit [1/s^n]: for larger ones, times are rounding
_MAX_BYTES = 1_000_000  # maximum size of a file
_NEEDED = "acceleration", "jerk"
FRANKA = "franka"  # the Panda or the FR3, depending on the names of the joints


def limits_of(
    limits: GivenLimits,
    names: Sequence[str],
    followers: Mapping[str, Drive] | None = None,
    needed: Collection[str] = _NEEDED,
) -> ArmLimits:
    """The limits of an arm by its name, or from a file or its mapping.

    Args:
        limits: A name in ``ARMS``, "franka" (the FR3 if a joint's name contains "fr3", else the Panda), a file ``*.yaml``, or its
            mapping.
        names: The names of the entries of q.
        followers: The drive of each mimic joint, whose limits a file may contain too.
        needed: The quantities that a file must have for all joints or for none. In others NaN stands for no limit.

    Raises:
        UnknownNameError: There is no such name, and it does not end in ``.yaml``.
        InputError: The arm has another number of joints.
        FileError, DescriptionError: The file cannot be read, or is not a file of joint limits.
    """
    if isinstance(limits, Mapping):
        return _check_complete(arm_limits_of(limits, names, followers or {}, "limits"), names, needed)
    if not isinstance(limits, str | Path):
        raise InputError("limits", f"{cited(limits)}; the name of an arm or a file joint_limits.yaml is expected")
    if Path(limits).suffix in {".yaml", ".yml"}:
        return read_joint_limits(Path(limits), names, followers, needed)
    name = str(limits)
    if name == FRANKA:
        name = "fr3" if any("fr3" in joint.lower() for joint in names) else "panda"
    if name not in ARMS:
        raise UnknownNameError("set of limits", name, (FRANKA, *ARMS), "; a file has to end in .yaml")
    if len(ARMS[name].velocity) != len(names):
        few, many = len(ARMS[name].velocity), f"{len(names)} ({', '.join(names)})"
        raise InputError("limits", f"{name} has {count_of(few, 'joint')}, the robot has {many}; a .yaml file names its joints")
    return ARMS[name]


def velocities_of(arm: ArmLimits, described: Array) -> Array:
    """The velocity limits of an arm, or of the description where it has none, shape (n,) [rad/s or m/s]."""
    return np.where(np.isnan(arm.velocity), described, arm.velocity)


def limit_to_robot(arm: ArmLimits, tree: Tree) -> tuple[ArmLimits, PositionLimits]:
    """The limits of an arm, with the robot's velocities where it has none, and within the robot's narrowed limits."""
    described = np.where(tree.velocity_limits > 0.0, tree.velocity_limits, np.inf)
    kept = {"velocity": velocities_of(arm, described), "acceleration": arm.acceleration, "jerk": arm.jerk}
    for name, most in kept.items():
        cap = np.inf if tree.narrowed is None else getattr(tree.narrowed, name)
        if most is not None or np.isfinite(cap).any():
            kept[name] = np.fmin(np.inf if most is None else most, cap)
    return arm._replace(**kept), _positions(arm, tree)


def _positions(arm: ArmLimits | None, tree: Tree) -> PositionLimits:
    own = PositionLimits(tree.lower, tree.upper)
    return own if arm is None or arm.lower is None or arm.upper is None else own.narrowed(PositionLimits(arm.lower, arm.upper))


def as_motion_limits(
    tree: Tree,
    velocity: ArrayLike | None,
    acceleration: ArrayLike | None,
    jerk: ArrayLike | None,
    limits: GivenLimits | None,
) -> tuple[Limits, PositionLimits]:
    """The limits of a motion: given numbers first, then ``limits``, then the limits of the robot.

    They are never wider than narrowed limits of the robot (``Robot.with_limits``).

    Raises:
        InputError: No acceleration is given, a limit is not above 0, or the description has a velocity limit of 0.
        UnknownNameError, FileError, DescriptionError: See ``limits_of``.
    """
    names, n = entry_names(tree), tree.n_dof
    needed = [name for name, given in zip(_NEEDED, (acceleration, jerk), strict=True) if given is None]
    arm = None if limits is None else limits_of(limits, names, tree.followers, needed)
    shares = (1.0, 1.0) if arm is None else arm.scaling
    if velocity is None:
        known = tree.velocity_limits if arm is None else velocities_of(arm, tree.velocity_limits)
        if not known.all():
            still = ", ".join(repr(name) for name, most in zip(names, known, strict=True) if not most)
            raise InputError(
                "velocity", f"the description allows {still} a velocity of 0, so no trajectory exists; give velocity="
            )
        velocity = shares[0] * known
    if acceleration is None and arm is not None and arm.acceleration is not None:
        acceleration = shares[1] * arm.acceleration
    if jerk is None and arm is not None:
        jerk = arm.jerk
    speeds = as_limits("velocity", velocity, n, may_be_infinite=True)
    if tree.narrowed is not None:
        speeds = np.minimum(speeds, tree.narrowed.velocity)
    named = "the mapping" if isinstance(limits, Mapping) else limits
    kept = cap_limits(tree, acceleration, jerk, "" if arm is None else f"{named} has none ({arm.source})")
    return Limits(speeds, *kept), _positions(arm, tree)


def cap_limits(
    tree: Tree, acceleration: ArrayLike | None, jerk: ArrayLike | None, missing: str = ""
) -> tuple[Array, Array | None]:
    """The limits of acceleration and jerk, shape (n_dof,) each; the robot's unless given.

    They are never wider than narrowed limits of the robot. missing: the beginning of the message if no acceleration is known.

    Raises:
        InputError: No acceleration is known, or a limit is not above 0.
    """
    own, caps, n = described_limits(tree), tree.narrowed, tree.n_dof
    if acceleration is None:
        acceleration = own.acceleration
        if not (acceleration < np.inf).all() or not acceleration.all():
            lacking = _describe_lacking(acceleration, entry_names(tree))
            raise InputError("acceleration", f"{missing or 'none is given'}{lacking}; give acceleration=")
    jerk = own.jerk if jerk is None else jerk
    most, most_jerk = as_limits("acceleration", acceleration, n), None if jerk is None else as_limits("jerk", jerk, n)
    if caps is None:
        return most, most_jerk
    return np.minimum(most, caps.acceleration), None if most_jerk is None else np.minimum(most_jerk, caps.jerk)


def described_limits(tree: Tree) -> Limits:
    """The robot's own limits; infinite where it has none, and None for jerk if it has no jerk limit."""
    rates = tree.acceleration_limits, tree.jerk_limits
    acceleration, jerk = (np.where(own < np.inf, np.minimum(own, LARGEST), np.inf) for own in rates)
    return Limits(tree.velocity_limits, acceleration, np.minimum(jerk, LARGEST) if (jerk < np.inf).any() else None)


def _describe_lacking(own: Array, names: Sequence[str]) -> str:
    """The part of a message that names joints without a limit above 0; empty if all lack one."""
    lacking = ~(own < np.inf) | (own == 0.0)
    few = ", ".join(repr(name) for name, lacks in zip(names, lacking, strict=True) if lacks)
    return "" if np.isinf(own).all() else f", and the robot has none above 0 for {few}"


def as_limits(name: str, given: ArrayLike, n_dof: int, *, may_be_infinite: bool = False) -> Array:
    """Check limits, one number above 0 or n_dof numbers, and return n_dof numbers.

    Raises:
        InputError: They are neither, or exceed 1e9; a velocity may be infinite.
    """
    limits = as_floats(name, given)
    if limits.shape not in {(), (n_dof,)} or not (limits > 0).all():
        raise InputError(name, f"{given!r}; a number above 0, or {n_dof} of them, is expected")
    beyond = limits > LARGEST
    if (beyond & (limits < np.inf) if may_be_infinite else beyond).any():
        raise InputError(name, f"{given!r}; at most {LARGEST:g} is expected{', or inf' if may_be_infinite else ''}")
    return np.full(n_dof, limits)


def read_joint_limits(
    path: Path, names: Sequence[str], followers: Mapping[str, Drive] | None = None, needed: Collection[str] = _NEEDED
) -> ArmLimits:
    """Read the limits of named joints from a file.

    A joint without a velocity (NaN here) keeps the description's. Other joints of the file are ignored. followers and needed: see
    ``limits_of``.

    Raises:
        FileError: The file cannot be read.
        DescriptionError: It is not YAML, has no ``joint_limits`` or none of these joints, or a limit is invalid.
    """
    try:
        text = file_bytes(path, _MAX_BYTES)
    except OSError as error:
        raise FileError(str(path), reason_of(error)) from None
    if len(text) > _MAX_BYTES:
        raise FileError(str(path), f"has more than {_MAX_BYTES} bytes")
    return _check_complete(arm_limits_of(_document(text, str(path)), names, followers or {}, str(path)), names, needed)


def _document(text: bytes, source: str) -> Any:
    """Parse the YAML of a file."""
    try:
        return yaml_value(text, {"!degrees": lambda angle: math.radians(float(angle)), "!radians": float})
    except ValueError as error:
        raise DescriptionError(f"not YAML ({error})", source) from None


def _check_complete(arm: ArmLimits, names: Sequence[str], needed: Collection[str]) -> ArmLimits:
    """The limits of a file, with None for a quantity that it has for no joint.

    Raises:
        DescriptionError: It has a needed quantity for some joints, but not for all.
    """
    stated = {name: getattr(arm, name) for name in _NEEDED}
    for name, limits in stated.items():
        missing = np.isnan(limits)
        if name in needed and missing.any() and not missing.all():
            without = ", ".join(joint for joint, none in zip(names, missing, strict=True) if none)
            raise DescriptionError(f"limits the {name} of some joints, but not of {without}", arm.source)
    return arm._replace(**{name: None if np.isnan(limits).all() else limits for name, limits in stated.items()})
