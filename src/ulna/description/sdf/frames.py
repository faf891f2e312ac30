"""Resolves the frames of an SDF model: the base of each pose, and the link of each frame."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.errors import DescriptionError, did_you_mean
from ulna.kernels.layout import LARGEST

Array = NDArray[np.float64]
MODEL = "__model__"
WORLD = "world"
OUTSIDE = "world::"
"""The scope of the frames of a world, in which the model's own pose is given."""


class Place(NamedTuple):
    """The element that an error is about: its document, line and name in words."""

    source: str
    line: int | None
    words: str

    def fail(self, message: str) -> DescriptionError:
        """An error that names the element."""
        return DescriptionError(f"{self.words}: {message}", self.source, self.line)


@dataclass
class Frame:
    """A frame as written.

    Attributes:
        kind: Its element: ``"link"``, ``"joint"``, ``"frame"`` or ``"model"``.
        place: Its element.
        scope: The scope of the names in it: ``""`` for the robot, ``"a::"`` for its model a. Names in a model's own links are
            looked up in the model.
        base: The frame that the pose is relative to.
        pose: T_base_frame.
        attached_to: The frame that it moves with; for a link itself.
    """

    kind: str
    place: Place
    scope: str
    base: str
    pose: Array
    attached_to: str


@dataclass
class Frames:
    """The frames of a model and of its nested models, by their names from outside, such as ``"arm::hand"``."""

    frames: dict[str, Frame] = field(default_factory=dict)
    poses: dict[str, Array] = field(default_factory=lambda: {WORLD: np.eye(4)})
    bodies: dict[str, str] = field(default_factory=lambda: {WORLD: WORLD})

    def add(self, key: str, frame: Frame) -> None:
        """Add a frame, whose name must be new."""
        if key in self.frames or f"{key}::{MODEL}" in self.frames:
            raise frame.place.fail("another link, joint, frame or model of the same model has its name")
        self.frames[key] = frame
        if frame.kind == "link":
            self.bodies[key] = key

    def find(self, scope: str, name: str, place: Place) -> str:
        """The frame that a name in a scope refers to."""
        if scope == OUTSIDE and name == WORLD:
            return WORLD
        for key in (scope + name, f"{scope}{name}::{MODEL}"):
            if key in self.frames:
                return key
        known = [key.removeprefix(scope).removesuffix(f"::{MODEL}") for key in self.frames if key.startswith(scope)]
        raise place.fail(f"frame {name!r} is not defined{did_you_mean(name, known)}")

    def pose_of(self, key: str) -> Array:
        """T_world_frame, with all joints at zero."""
        for each, base in self._chain(key, self.poses, "base"):
            T = self.poses[base] @ self.frames[each].pose
            if np.abs(T[:3, 3]).max() > LARGEST:
                raise self.frames[each].place.fail(f"its position is beyond {LARGEST:g} m")
            self.poses[each] = T
        return self.poses[key]

    def between(self, one: str, other: str) -> Array:
        """T_one_other, with all joints at zero."""
        return inverse(self.pose_of(one)) @ self.pose_of(other)

    def body_of(self, key: str) -> str:
        """The link that a frame is attached to, or the world."""
        for each, to in self._chain(key, self.bodies, "attached_to"):
            self.bodies[each] = self.bodies[to]
        return self.bodies[key]

    def put(self, model: str, name: str) -> None:
        """Apply the pose of a model to one of its frames, its placement frame."""
        frame, placed = self.frames[model], np.eye(4)
        for each, _ in self._chain(self.find(model.removesuffix(MODEL), name, frame.place), {model: placed}, "base"):
            placed = placed @ self.frames[each].pose
        frame.pose = frame.pose @ inverse(placed)

    def _chain(self, key: str, known: dict, reference: str) -> list[tuple[str, str]]:
        """The frames from a known one to ``key``, each with its reference; the known frame is excluded."""
        chain: dict[str, str] = {}
        while key not in known:
            frame, start = self.frames[key], key
            if key in chain:
                names = " -> ".join([*list(chain)[-6:], key])
                raise frame.place.fail(f"frames are relative or attached to each other in a circle: {names}")
            is_inside = reference == "attached_to" and frame.kind == "model"
            scope = key.removesuffix(MODEL) if is_inside else frame.scope
            key = self.find(scope, getattr(frame, reference), frame.place)
            chain[start] = key
        return list(chain.items())[::-1]
