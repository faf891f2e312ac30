"""Holds the changes of a robot that were made on its page: allowed contacts, limits, attached objects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ulna.collision.attached import Attached
from ulna.description.inertias import Payload
from ulna.description.pose import rpy_from_matrix
from ulna.errors import InputError
from ulna.robot import Robot

QUANTITIES = ("lower", "upper", "velocity", "acceleration")
Limits = Mapping[str, Mapping[str, float]]


class Changes(NamedTuple):
    """The changes of a robot.

    Attributes:
        allowed: Pairs of links that may touch.
        limits: For each quantity, narrower limits by the name of the joint [rad or m, and s].
        attached: Objects attached to its links.
    """

    allowed: tuple[tuple[str, str], ...] = ()
    limits: Limits = {}  # noqa: RUF012 - never changed
    attached: tuple[Attached, ...] = ()

    def apply_to(self, robot: Robot) -> Robot:
        """A robot with these changes; the robot itself if there are none.

        Raises:
            UlnaError: A limit or an object is invalid.
        """
        if self.allowed:
            robot = robot.with_allowed_collisions(self.allowed)
        if self.limits:
            robot = robot.with_limits(**self.limits)  # type: ignore[arg-type]
        for one in self.attached:
            options = {"link": one.link, "touch_links": one.touch_links, "mass": _mass(one)}
            robot = robot.with_attached(one.name, one.shape, one.T_link_object, **options)
        return robot

    def with_mass(self, held: Attached, mass: float) -> Changes:
        """Set the mass of an attached object [kg], spread evenly over its shape; 0 for none.

        Raises:
            InputError: The object came with the robot, or the mass is invalid.
        """
        if held.name not in {one.name for one in self.attached}:
            raise InputError(
                "mass", f"{held.name!r} came with the robot; to change its mass, use with_attached(..., mass=) in a program"
            )
        inertia = Payload(mass or None).of(held.shape)
        return self._replace(
            attached=tuple(replace(one, inertia=inertia) if one.name == held.name else one for one in self.attached)
        )

    def with_limit(self, robot: Robot, quantity: str, joint: str, value: float) -> Changes:
        """Set a limit of a joint. The limit of the unchanged ``robot`` removes the change."""
        column = robot.joint_slices[robot.joint_names.index(joint)].start
        own = limits_of(robot, column)[quantity]
        of_joints = {name: each for name, each in self.limits.get(quantity, {}).items() if name != joint}
        of_joints |= {} if np.isclose(value, own, atol=1e-9) else {joint: float(value)}
        limits = {**self.limits, quantity: of_joints}
        return self._replace(limits={name: each for name, each in limits.items() if each})

    def as_expression(self) -> str:
        """A Python expression that makes these changes to ``robot``."""
        calls = [f".with_allowed_collisions({list(self.allowed)!r})"] if self.allowed else []
        if self.limits:
            calls.append(f".with_limits({', '.join(f'{name}={dict(each)!r}' for name, each in self.limits.items())})")
        for one in self.attached:
            T = one.T_link_object
            place = f"ulna.pose({T[:3, 3].tolist()}, {list(map(float, rpy_from_matrix(T)))})"
            mass = "" if _mass(one) is None else f", mass={_mass(one):g}"
            calls.append(f".with_attached({one.name!r}, ulna.{one.shape!r}, {place}, link={one.link!r}{mass})")
        return "".join(["robot", *calls])

    def describe(self) -> str:
        """Sentences that list the changes; empty if there are none."""
        joints = dict.fromkeys(joint for of_joints in self.limits.values() for joint in of_joints)
        words = {
            "These links may touch": [" and ".join(pair) for pair in self.allowed],
            "Narrower limits": joints,
            "Attached": [
                f"{one.name} to {one.link}" + ("" if _mass(one) is None else f" with {_mass(one):g} kg") for one in self.attached
            ],
        }
        return ". ".join(f"{what}: {', '.join(each)}" for what, each in words.items() if each)


def limits_of(robot: Robot, column: int) -> dict[str, float]:
    """The limits of an entry of q, by quantity; a missing limit is infinite."""
    values = robot.lower, robot.upper, robot.velocity_limits, robot.acceleration_limits
    return {name: float(each[column]) for name, each in zip(QUANTITIES, values, strict=True)}


def _mass(one: Attached) -> float | None:
    """The mass of an attached object [kg]; None for an object without inertia."""
    return None if one.inertia is None else one.inertia.mass
