"""The limits of a motion: numbers, the name of an arm, a file ``joint_limits.yaml`` as MoveIt has it, or the mapping of one.

``joint_limits`` says what is read of it. Numbers may have the tags !degrees and !radians, which the files of some arms have.
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
GivenLimits = str | Path | Mapping[str, Any]  # the name of an arm, a file, or what is in it
LARGEST = 1e9  # of a limit [1/s^n]: above, the times are rounding
_MAX_BYTES = 1_000_000  # of a file
_NEEDED = "acceleration", "jerk"
FRANKA = "franka"  # the Panda or the FR3, by the names of the joints


def limits_of(
    limits: GivenLimits,
    names: Sequence[str],
    followers: Mapping[str, Drive] | None = None,
    needed: Collection[str] = _NEEDED,
) -> ArmLimits:
    """The limits of an arm by its name, or of a file or its mapping.

    Args:
        limits: A name in ``ARMS``, "franka" (the FR3 where the names of the joints say so, else the Panda), a file ``*.yaml``, or
            the mapping of one.
        names: Those of the entries of q.
        followers: What moves each mimic joint, of which a file may have limits too.
        needed: The quantities that a file limits for every joint or for none. Of others NaN stands for no limit.

    Raises:
        UnknownNameError: There is no such name, and it is no ``*.yaml``.
        InputError: The arm has another number of joints.
        FileError, DescriptionError: The file cannot be read, or is not a file of joint limits.
    """
    if isinstance(limits, Mapping):
        return _every_or_none(arm_limits_of(limits, names, followers or {}, "limits"), names, needed)
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
    """The velocities of an arm, and where it states none those of the description, shape (n,) [rad/s or m/s]."""
    return np.where(np.isnan(arm.velocity), described, arm.velocity)


def within_robot(arm: ArmLimits, tree: Tree) -> tuple[ArmLimits, PositionLimits]:
    """The limits of an arm, with velocities of the robot where it states none, and within what the robot was narrowed to."""
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
    """The limits of a motion: what is given as numbers, then what ``limits`` states, then those of the robot.

    Where the robot was narrowed (``Robot.with_limits``) they are never wider than that.

    Raises:
        InputError: No acceleration is given, one of them is not above 0, or the description allows a joint no velocity.
        UnknownNameError, FileError, DescriptionError: As for ``limits_of``.
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
                "velocity", f"the description allows {still} a velocity of 0, so no motion has times; give velocity="
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
    kept = within_caps(tree, acceleration, jerk, "" if arm is None else f"{named} states none ({arm.source})")
    return Limits(speeds, *kept), _positions(arm, tree)


def within_caps(
    tree: Tree, acceleration: ArrayLike | None, jerk: ArrayLike | None, missing: str = ""
) -> tuple[Array, Array | None]:
    """The limits of acceleration and jerk, shape (n_dof,); where none are given those of the robot.

    They are never wider than what the robot was narrowed to. missing: says where no acceleration was found.

    Raises:
        InputError: No acceleration is known, or one of them is not above 0.
    """
    own, caps, n = described_limits(tree), tree.narrowed, tree.n_dof
    if acceleration is None:
        acceleration = own.acceleration
        if not (acceleration < np.inf).all() or not acceleration.all():
            lacking = _lacking(acceleration, entry_names(tree))
            raise InputError("acceleration", f"{missing or 'none is given'}{lacking}; give acceleration=")
    jerk = own.jerk if jerk is None else jerk
    most, most_jerk = as_limits("acceleration", acceleration, n), None if jerk is None else as_limits("jerk", jerk, n)
    if caps is None:
        return most, most_jerk
    return np.minimum(most, caps.acceleration), None if most_jerk is None else np.minimum(most_jerk, caps.jerk)


def described_limits(tree: Tree) -> Limits:
    """The limits of the entries of q that the robot has; infinite where it states none, no jerk where it has none."""
    rates = tree.acceleration_limits, tree.jerk_limits
    acceleration, jerk = (np.where(own < np.inf, np.minimum(own, LARGEST), np.inf) for own in rates)
    return Limits(tree.velocity_limits, acceleration, np.minimum(jerk, LARGEST) if (jerk < np.inf).any() else None)


def _lacking(own: Array, names: Sequence[str]) -> str:
    """Which joints of a robot that has some of these limits lack one above 0."""
    lacking = ~(own < np.inf) | (own == 0.0)
    few = ", ".join(repr(name) for name, lacks in zip(names, lacking, strict=True) if lacks)
    return "" if np.isinf(own).all() else f", and the robot has none above 0 of {few}"


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


def read_joint_limits(
    path: Path, names: Sequence[str], followers: Mapping[str, Drive] | None = None, needed: Collection[str] = _NEEDED
) -> ArmLimits:
    """The limits of the joints called so.

    A joint without a velocity keeps that of its description (NaN here). Joints that the robot has not are ignored. followers and
    needed: as of ``limits_of``.

    Raises:
        FileError: The file cannot be read.
        DescriptionError: It is not YAML, has no ``joint_limits`` or none of these joints, or a limit is none.
    """
    try:
        text = file_bytes(path, _MAX_BYTES)
    except OSError as error:
        raise FileError(str(path), reason_of(error)) from None
    if len(text) > _MAX_BYTES:
        raise FileError(str(path), f"has more than {_MAX_BYTES} bytes")
    return _every_or_none(arm_limits_of(_document(text, str(path)), names, followers or {}, str(path)), names, needed)


def _document(text: bytes, source: str) -> Any:
    """Parse the YAML of a file."""
    try:
        return yaml_value(text, {"!degrees": lambda angle: math.radians(float(angle)), "!radians": float})
    except ValueError as error:
        raise DescriptionError(f"not YAML ({error})", source) from None


def _every_or_none(arm: ArmLimits, names: Sequence[str], needed: Collection[str]) -> ArmLimits:
    """The limits of a file: None for a quantity that it does not state of any joint.

    Raises:
        DescriptionError: It states a quantity that is needed, but not of all joints.
    """
    stated = {name: getattr(arm, name) for name in _NEEDED}
    for name, limits in stated.items():
        missing = np.isnan(limits)
        if name in needed and missing.any() and not missing.all():
            without = ", ".join(joint for joint, none in zip(names, missing, strict=True) if none)
            raise DescriptionError(f"limits the {name} of some joints, but not of {without}", arm.source)
    return arm._replace(**{name: None if np.isnan(limits).all() else limits for name, limits in stated.items()})
