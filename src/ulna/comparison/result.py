"""Holds the result of a comparison, as frozen data. Used by all of ``comparison`` and ``ulna compare``."""

from dataclasses import dataclass

KINDS = ("link", "joint", "order", "type", "parent", "origin", "axis", "limits", "mimic", "pose", "visual", "collision")


@dataclass(frozen=True)
class Difference:
    """One thing that differs. ``kind`` is one of ``KINDS``, ``where`` a joint or a link, ``a`` and ``b`` what each has there."""

    kind: str
    where: str
    a: str
    b: str


@dataclass(frozen=True)
class PoseDifference:
    """The largest distance [m] and angle [rad] between two links that correspond, over random configurations."""

    link_a: str
    link_b: str
    position: float
    rotation: float


@dataclass(frozen=True)
class Tolerances:
    """What still counts as the same: ``position`` [m], ``rotation`` [rad], and ``limit`` in a limit's own unit."""

    position: float = 1e-6
    rotation: float = 1e-6
    limit: float = 1e-6


@dataclass(frozen=True)
class Comparison:
    """How two robots differ: not at all if there are no ``differences``.

    ``poses`` has every pair of links, the same or not. Joints are matched by their names, or ``matched_by`` their order where
    hardly a name is shared. Poses are those in ``frame_a`` and ``frame_b``, at ``n_configurations`` random configurations.
    """

    name_a: str
    name_b: str
    differences: tuple[Difference, ...]
    poses: tuple[PoseDifference, ...]
    matched_by: str
    frame_a: str
    frame_b: str
    n_configurations: int
    tolerances: Tolerances

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    @property
    def max_position_difference(self) -> float:
        """The largest distance [m] between two links that correspond."""
        return max((pose.position for pose in self.poses), default=0.0)

    @property
    def max_rotation_difference(self) -> float:
        """The largest angle [rad] between two links that correspond."""
        return max((pose.rotation for pose in self.poses), default=0.0)

    def __str__(self) -> str:
        lines = [f"{d.kind} {d.where}: {d.a} | {d.b}" for d in self.differences]
        return "\n".join([f"{self.name_a} | {self.name_b}: {len(lines) or 'no'} difference{'s' * (len(lines) != 1)}", *lines])
