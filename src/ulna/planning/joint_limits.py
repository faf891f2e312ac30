"""Reads a mapping ``joint_limits``, as in files of MoveIt and ros2_control or parameters of a ROS 2 node.

It reads for each joint ``min_position`` and ``max_position``, ``max_velocity``, ``max_acceleration``, ``max_deceleration``,
``max_jerk``, the corresponding ``min_...``, and ``has_..._limits``. Efforts and ``angle_wraparound`` do not limit motions. Other
keys give a warning.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.structure import Drive
from ulna.errors import DescriptionError, DescriptionWarning, cited, listed
from ulna.planning.arm_limits import ArmLimits

Array = NDArray[np.float64]
_KEY = "joint_limits"
_DEEPEST = 8  # maximum nesting of mappings in a parameter file
_LARGEST = 1e9  # the maximum of a limit: for larger ones, times are rounding
_SCALING = "default_velocity_scaling_factor", "default_acceleration_scaling_factor"
_KINDS = "position", "velocity", "acceleration", "deceleration", "jerk"
_READ = {*(f"{end}_{kind}" for end in ("min", "max") for kind in _KINDS), *(f"has_{kind}_limits" for kind in _KINDS)}
_MEANING_NOTHING = {"has_effort_limits", "max_effort", "angle_wraparound"}


class _JointLimits(NamedTuple):
    """The limits of a joint in a document: missing positions are infinite, missing magnitudes NaN."""

    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.nan
    acceleration: float = math.nan
    jerk: float = math.nan


def arm_limits_of(document: Any, names: Sequence[str], followers: Mapping[str, Drive], source: str) -> ArmLimits:
    """The limits of the entries of q in a document; NaN for limits that it does not have.

    Args:
        document: The content of a file.
        names: The names of the entries of q. Other joints of the document are ignored.
        followers: The drive of each mimic joint: its limits narrow the limits of its leader.
        source: The name of the document, for messages.

    Raises:
        DescriptionError: There is no mapping joint_limits, or it has none of these joints, or a limit is invalid.
    """
    beside = _mapping_with_limits(document, source)
    joints = beside[_KEY]
    if not any(name in joints for name in (*names, *followers)):
        has = listed([str(joint)[:80] for joint in joints]) or "none"
        raise DescriptionError(f"has none of the joints {', '.join(names)}; it has {has}", source)
    stated, unknown = [_JointLimits()] * len(names), []
    for k, name in enumerate(names):
        if name in joints:
            stated[k] = _read_joint(joints[name], name, source, unknown)
    for name, drive in followers.items():
        if name in joints and drive.column is not None:
            stated[drive.column] = _narrow(stated[drive.column], _read_joint(joints[name], name, source, unknown), drive)
    if unknown:
        warnings.warn(f"{source}: {listed(unknown)}: unknown and ignored", DescriptionWarning, stacklevel=6)
    lower, upper, velocity, acceleration, jerk = np.array(stated).T
    velocity_share, acceleration_share = (_scaling(beside, key, source) for key in _SCALING)
    return ArmLimits(velocity, acceleration, jerk, source, lower=lower, upper=upper, scaling=(velocity_share, acceleration_share))


def _mapping_with_limits(document: Any, source: str) -> dict[str, Any]:
    """The mapping that contains ``joint_limits``: the document, or a nested mapping, as in parameters of a ROS 2 node."""
    found = list(_find_mappings(document, "", _DEEPEST, set()))
    if not found:
        raise DescriptionError("has no mapping joint_limits", source)
    if any(each[_KEY] != found[0][1][_KEY] for _, each in found[1:]):
        raise DescriptionError(
            f"has several mappings joint_limits, which differ: under {listed([at for at, _ in found])}", source
        )
    return found[0][1]


def _find_mappings(mapping: Any, at: str, depth: int, seen: set[int]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each mapping that contains joint limits, with its path. Mappings with several aliases are visited once."""
    if not isinstance(mapping, Mapping) or not depth or id(mapping) in seen:
        return
    seen.add(id(mapping))
    mapping = _nest_dotted_names(mapping)
    if isinstance(mapping.get(_KEY), Mapping):
        yield at or "the top", mapping
        return
    for name, each in mapping.items():
        yield from _find_mappings(each, f"{at}/{name}" if at else str(name), depth - 1, seen)


def _nest_dotted_names(mapping: Mapping[Any, Any]) -> dict[Any, Any]:
    """Convert dotted names, as ROS 2 writes parameters, to nested mappings."""
    if not any(isinstance(name, str) and f"{_KEY}." in name for name in mapping):
        return dict(mapping)
    nested: dict[Any, Any] = {}
    for name, value in mapping.items():
        *outer, last = name.split(".") if isinstance(name, str) and _KEY in name.split(".") else (name,)
        inner = nested
        for part in outer:
            inner = inner.setdefault(part, {})
            if not isinstance(inner, dict):
                return dict(mapping)
        inner[last] = value
    return nested


def _read_joint(joint: Any, name: str, source: str, unknown: list[str]) -> _JointLimits:
    """Read the limits of a joint in a document; unknown keys are added to ``unknown``."""
    if not isinstance(joint, Mapping):
        raise DescriptionError(f"{name}: a mapping is expected, not {cited(joint)}", source)
    unknown += [f"{name}.{key}" for key in joint if key not in _READ and key not in _MEANING_NOTHING]
    of_joint = _Joint(joint, name, source)
    lower, upper = of_joint.positions()
    velocity, acceleration, slowing, jerk = map(of_joint.magnitude, _KINDS[1:])
    return _JointLimits(lower, upper, velocity, float(np.fmin(acceleration, slowing)), jerk)


class _Joint(NamedTuple):
    """The mapping of a joint in a document."""

    given: Mapping[str, Any]
    name: str
    source: str

    def positions(self) -> tuple[float, float]:
        """The minimum and the maximum position; infinite where missing."""
        low, high = (self.given.get(f"{end}_position") for end in ("min", "max"))
        if not self._has("position", stated=low is not None or high is not None):
            return -math.inf, math.inf
        lower = -math.inf if low is None else self._number("min_position", low)
        upper = math.inf if high is None else self._number("max_position", high)
        if not lower < upper:
            raise self._error(f"min_position is {lower:g}, and max_position is {upper:g}: a range is expected")
        return lower, upper

    def magnitude(self, kind: str) -> float:
        """The maximum magnitude of a kind that holds in both directions; NaN if missing."""
        high, low = self.given.get(f"max_{kind}"), self.given.get(f"min_{kind}")
        if not self._has(kind, stated=high is not None or low is not None):
            return math.nan
        most = math.inf if high is None and low is not None else self._number(f"max_{kind}", high, above_0=True)
        if low is None:
            return most
        least = self._number(f"min_{kind}", low)
        if not least < 0.0:
            raise self._error(f"min_{kind} is {least:g}; one below 0 is expected, the greatest in the negative direction")
        return min(most, -least)

    def _has(self, kind: str, *, stated: bool) -> bool:
        key = f"has_{kind}_limits"
        has = self.given.get(key, stated)
        if not isinstance(has, bool):
            raise self._error(f"{key} is {cited(has)}; true or false is expected")
        return has

    def _number(self, key: str, value: Any, *, above_0: bool = False) -> float:
        is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST
        if not is_number or (above_0 and not value > 0.0):
            expected = "a number above 0" if above_0 else "a finite number"
            raise self._error(f"{key} is {cited(value)}; {expected} is expected, at most {_LARGEST:g}")
        return float(value)

    def _error(self, message: str) -> DescriptionError:
        return DescriptionError(f"{self.name}: {message}", self.source)


def _narrow(leader: _JointLimits, follower: _JointLimits, drive: Drive) -> _JointLimits:
    """Narrow the limits of a leader by the limits of a mimic joint that follows it."""
    low, high = sorted((end - drive.offset) / drive.ratio for end in (follower.lower, follower.upper))
    rates = (float(np.fmin(own, other / abs(drive.ratio))) for own, other in zip(leader[2:], follower[2:], strict=True))
    return _JointLimits(max(leader.lower, low), min(leader.upper, high), *rates)


def _scaling(mapping: Mapping[str, Any], key: str, source: str) -> float:
    """A default scaling factor of the limits; 1 if missing."""
    share = mapping.get(key, 1.0)
    if isinstance(share, bool) or not isinstance(share, int | float) or not 0.0 < share <= 1.0:
        raise DescriptionError(f"{key} is {cited(share)}; a number above 0 and at most 1 is expected", source)
    return float(share)
