"""Holds a semantic description (SRDF) as frozen data: groups, states, allowed pairs."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """Joints and links under one name: those listed, those of ``chains`` (base link, tip link) and those of other groups."""

    name: str
    links: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    chains: tuple[tuple[str, str], ...] = ()
    subgroups: tuple[str, ...] = ()
    line: int | None = None


@dataclass(frozen=True)
class EndEffector:
    """The links of ``group``, which are attached to ``parent_link``; ``parent_group`` moves them, if given."""

    name: str
    parent_link: str
    group: str
    parent_group: str | None = None
    line: int | None = None


@dataclass(frozen=True)
class GroupState:
    """A posture of some joints, by name: of a prismatic one [m], of a revolute one [rad].

    A planar joint has x, y, theta; a floating one x, y, z and a quaternion x, y, z, w, as in the file.
    """

    name: str
    group: str | None
    values: tuple[tuple[str, tuple[float, ...]], ...] = ()
    line: int | None = None

    @property
    def key(self) -> str:
        """``group/name``; the name alone where the file names no group."""
        return self.name if self.group is None else f"{self.group}/{self.name}"


@dataclass(frozen=True)
class DisabledCollision:
    """Two links that are not checked against each other, and why: ``Adjacent``, ``Never``, ``User`` ..., or ``""``."""

    link_a: str
    link_b: str
    reason: str = ""
    line: int | None = None


@dataclass(frozen=True)
class VirtualJoint:
    """How the robot's ``child_link`` may move in a frame of the world; Ulna's base is fixed, so it has no entry of q."""

    name: str
    type: str
    parent_frame: str
    child_link: str
    line: int | None = None


@dataclass(frozen=True)
class Srdf:
    """A semantic description.

    ``warnings`` are sentences with file and line, one for each reference to a link, joint or group that is not there: files that
    are in use have many. Such a reference is ignored. ``unchecked_links`` are checked against no other but where
    ``enabled_collisions`` says so (``disable_default_collisions`` and ``enable_collisions``); a robot's own ``srdf`` has those
    pairs among its ``disabled_collisions``. ``found_at`` is its path where ``ulna.load`` found it beside the URDF, empty where it
    was given. ``passed_over`` has a sentence for each file or package that was found there and is not used, with the reason.
    """

    name: str = ""
    groups: tuple[Group, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    states: tuple[GroupState, ...] = ()
    disabled_collisions: tuple[DisabledCollision, ...] = ()
    virtual_joints: tuple[VirtualJoint, ...] = ()
    passive_joints: tuple[str, ...] = ()
    unchecked_links: tuple[str, ...] = ()
    enabled_collisions: tuple[tuple[str, str], ...] = ()
    source: str = ""
    warnings: tuple[str, ...] = ()
    found_at: str = ""
    passed_over: tuple[str, ...] = ()
