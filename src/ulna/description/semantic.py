"""Holds a semantic description (SRDF) as frozen data: groups, states, allowed pairs."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """Joints and links under one name: listed ones, those of ``chains`` (base link, tip link) and of other groups."""

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
    """A posture of some joints, by name: prismatic ones [m], revolute ones [rad].

    A planar joint has x, y, theta; a floating one x, y, z and a quaternion x, y, z, w, as in the file.
    """

    name: str
    group: str | None
    values: tuple[tuple[str, tuple[float, ...]], ...] = ()
    line: int | None = None

    @property
    def key(self) -> str:
        """``group/name``; the name alone if the file names no group."""
        return self.name if self.group is None else f"{self.group}/{self.name}"


@dataclass(frozen=True)
class DisabledCollision:
    """Two links that are not checked against each other, and the reason: ``Adjacent``, ``Never``, ``User`` ..., or ``""``."""

    link_a: str
    link_b: str
    reason: str = ""
    line: int | None = None


@dataclass(frozen=True)
class VirtualJoint:
    """The motion of ``child_link`` in a world frame; Ulna's base is fixed, so q has no entry for it."""

    name: str
    type: str
    parent_frame: str
    child_link: str
    line: int | None = None


@dataclass(frozen=True)
class Srdf:
    """A semantic description.

    ``warnings`` are sentences with file and line, one for each reference to a missing link, joint or group, which is ignored:
    files in use have many. ``unchecked_links`` are checked against no other link, except for the pairs of ``enabled_collisions``
    (``disable_default_collisions`` and ``enable_collisions``). A robot's own ``srdf`` contains those pairs among its
    ``disabled_collisions``. ``found_at`` is its path if ``ulna.load`` found it next to the URDF, empty if it was given.
    ``passed_over`` has a sentence for each file or package found there but not used, with the reason.
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
