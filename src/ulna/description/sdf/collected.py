"""Collects the links, joints and frames of an SDF document and of the models that it includes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ulna.description.robot_description import Joint, JointType, LeftOut, Link
from ulna.description.sdf.files import ModelFiles
from ulna.description.sdf.frames import MODEL, OUTSIDE, WORLD, Array, Frames
from ulna.errors import listed

Z = (0.0, 0.0, 1.0)


@dataclass
class Collected:
    """A robot during collection; its links and joints are functions, called once all frames are known.

    Attributes:
        files: The models that it includes.
        frames: Its frames.
        links: A function per link that reads it.
        joints: A function per joint, by name, that returns the joint, and if needed a link without shapes and its fixed joint.
        moving: The names of the joints that are not fixed.
        left_out: The parts that are not read.
        unread: The count of each part that is for other programs.
        is_static: Whether nothing in it moves.
        opened: The content of each include.
        names: The names of its joints and frames.
    """

    files: ModelFiles
    frames: Frames = field(default_factory=Frames)
    links: list[Callable[[], Link]] = field(default_factory=list)
    joints: dict[str, Callable[[], tuple[list[Joint], list[Link]]]] = field(default_factory=dict)
    moving: list[str] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    unread: Counter[str] = field(default_factory=Counter)
    is_static: bool = False
    opened: dict[Any, Any] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def finished(self) -> tuple[list[Link], list[Joint]]:
        """The links and joints of the robot."""
        links, joints = [read() for read in self.links], []
        self.names = set(self.joints) | set(self.frames.frames)
        for read in () if self.is_static else self.joints.values():
            some, more = read()
            joints += some
            links += more
        if self.is_static and self.moving:
            message = f"is static, so its joints do not move: {listed(self.moving)}"
            self.left_out.append(LeftOut("model", message, self.frames.frames[MODEL].place.line))
        carried = {joint.child for joint in joints}
        roots = [link for link in links if link.name not in carried]
        is_on_world = any(joint.parent == WORLD for joint in joints)
        is_off = len(roots) == 1 and not np.array_equal(self.frames.pose_of(roots[0].name), np.eye(4))
        if self.is_static or (is_off and not is_on_world):
            joints = [*(self.fixed(WORLD, link.name, link.line) for link in roots), *joints]
            is_on_world = True
        self.add_frames(links, joints)
        return [*([Link(WORLD)] if is_on_world else []), *links], joints

    def add_frames(self, links: list[Link], joints: list[Joint]) -> None:
        """Add the frames as links without shapes, each fixed to the frame or link that it is attached to."""
        frames = self.frames
        for key, frame in frames.frames.items():
            if frame.kind == "frame" and not key.startswith(OUTSIDE):
                parent = frames.find(frame.scope, frame.attached_to, frame.place)
                if frames.frames[parent].kind != "frame":
                    parent = frames.body_of(parent)
                joints.append(self.fixed(parent, key, frame.place.line))
                links.append(Link(key, line=frame.place.line))

    def fixed(self, parent: str, child: str, line: int | None, origin: Array | None = None) -> Joint:
        """A fixed joint that the document does not contain."""
        origin = self.frames.between(parent, child) if origin is None else origin
        return Joint(self.unused(f"{child}_fixed"), JointType.FIXED, parent, child, origin, np.array(Z), line=line)

    def unused(self, name: str) -> str:
        """Reserve an unused name, based on ``name``."""
        while name in self.names:
            name += "_"
        self.names.add(name)
        return name
