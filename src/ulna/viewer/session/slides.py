"""Describes the sliders of joints: the range of each entry of q, grouped by limbs, and mimic joints."""

from collections import Counter
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from ulna.description.robot_description import JointType
from ulna.description.structure import columns_of_q, drives_of, joints_from_root
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

_MIN_RANGE = 1e-3  # [rad or m] the minimum range of a mimic joint's slider
_FREE = {"rad": pi, "m": 2.0}  # half the range of a joint without limits


@dataclass(frozen=True)
class Slide:
    """A slider of an entry of q, or of a mimic joint.

    The position of a mimic joint is ratio * q[column] + offset [rad or m]; q[column] belongs to its leader.
    """

    column: int
    name: str
    unit: str
    low: float
    high: float
    leader: str = ""
    ratio: float = 1.0
    offset: float = 0.0

    def position(self, q: NDArray[np.float64]) -> float:
        """The position at q, shape (n_dof,) [rad or m]."""
        return self.ratio * float(q[self.column]) + self.offset

    def shown(self, q: NDArray[np.float64]) -> float:
        """The position as the slider shows it: without whole turns, clipped to the range."""
        value = self.position(q)
        if self.unit == "rad" and self.high - self.low >= 2 * pi and not self.low <= value <= self.high:
            value = (value + pi) % (2 * pi) - pi
        return min(max(value, self.low), self.high)

    @property
    def hint(self) -> str:
        """A tooltip: the range of the joint, or the joint that it mimics."""
        if not self.leader:
            return f"{self.name}, {self.low:.4g} to {self.high:.4g} {self.unit}"
        factor = "" if self.ratio == 1 else f"{self.ratio:g} * "
        offset = f" + {self.offset:g}" if self.offset else ""
        return f"Mimic joint: {self.name} = {factor}{self.leader}{offset} [{self.unit}]"


@dataclass(frozen=True)
class SlideGroup:
    """The sliders of one limb of the robot, in one folder of the panel."""

    name: str
    slides: tuple[Slide, ...]
    followers: tuple[Slide, ...]


def slide_groups(robot: Robot) -> tuple[SlideGroup, ...]:
    """The sliders of all entries of q, in one group for each unbranched part of the tree.

    A serial arm has one group.
    """
    slides = _slides(robot)
    followers = _followers(robot, {slide.column: slide for each in slides.values() for slide in each})
    return tuple(
        SlideGroup(
            _group_name(limb),
            tuple(slide for name in limb for slide in slides[name]),
            tuple(follower for follower in followers if follower.leader in limb),
        )
        for limb in limbs(robot)
    )


def limbs(robot: Robot) -> list[list[str]]:
    """The names of the independent joints, one list for each unbranched part of the tree, in the order of q."""
    order = {name: k for k, name in enumerate(robot.joint_names)}
    moving, alive = [], set()  # the movable joints with their ancestors, and the parent links of these
    for joint in reversed(joints_from_root(robot.description)):
        if joint.name in order or joint.child in alive:
            moving.append(joint)
            alive.add(joint.parent)
    onwards = Counter(joint.parent for joint in moving)
    limb_of: dict[str, list[str]] = {robot.base: []}
    found = [limb_of[robot.base]]
    for joint in reversed(moving):
        if onwards[joint.parent] > 1:
            found.append([])
        limb = limb_of[joint.child] = limb_of[joint.parent] if onwards[joint.parent] == 1 else found[-1]
        limb += [joint.name] if joint.name in order else []
    return sorted((limb for limb in found if limb), key=lambda limb: order[limb[0]])


def _slides(robot: Robot) -> dict[str, list[Slide]]:
    """The sliders of each independent joint."""
    slides, entries = {}, coordinates_of(robot)
    for name, place in zip(robot.joint_names, robot.joint_slices, strict=True):
        slides[name] = [
            Slide(column, entries[column].name, entries[column].unit, *_range(robot, column, entries[column].unit))
            for column in range(place.start, place.stop)
        ]
    return slides


def _range(robot: Robot, column: int, unit: str) -> tuple[float, float]:
    low, high = float(robot.lower[column]), float(robot.upper[column])
    return (-_FREE[unit] if np.isinf(low) else low), (_FREE[unit] if np.isinf(high) else high)


def _followers(robot: Robot, slides: dict[int, Slide]) -> list[Slide]:
    """The sliders of the mimic joints; a mimic of a fixed joint does not move, and has none."""
    joints = joints_from_root(robot.description)
    drives = drives_of(joints, columns_of_q(joints), robot.description.source)
    leaders = {place.start: name for name, place in zip(robot.joint_names, robot.joint_slices, strict=True)}
    followers = []
    for joint in joints:
        drive = drives[joint.name]
        column, ratio, offset = drive.column, drive.ratio, drive.offset
        if joint.mimic is not None and column is not None:
            low, high = sorted(ratio * end + offset for end in (slides[column].low, slides[column].high))
            unit = "m" if joint.type == JointType.PRISMATIC else "rad"
            followers.append(Slide(column, joint.name, unit, low, max(high, low + _MIN_RANGE), leaders[column], ratio, offset))
    return followers


def _group_name(limb: list[str]) -> str:
    """The stem that most joint names of a limb share; otherwise their shared words, with the first and last name."""
    stems = [name.removesuffix("_joint").rstrip("_0123456789") for name in limb]
    stem, count = Counter(stems).most_common(1)[0]
    if 2 * count > len(limb) and len(stem) > 1:
        return stem
    words = [stem.split("_") for stem in stems]
    shared = next((k for k, each in enumerate(zip(*words, strict=False)) if len(set(each)) > 1), 0)
    first, last = ("_".join(names[shared:]) for names in (words[0], words[-1]))
    return f"{'_'.join(words[0][:shared])}: {first} to {last}" if shared else f"{first} to {last}"
