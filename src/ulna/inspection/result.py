"""Holds the results of an inspection and of a comparison, as frozen data."""

from dataclasses import dataclass, field
from enum import StrEnum


class Severity(StrEnum):
    """The severity of a finding.

    ``ERROR``: refused, or a contradiction. ``WARNING``: it works, but is probably not meant; or an unread part may change a
    result. ``NOTE``: good to know.
    """

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


ERROR, WARNING, NOTE = Severity


@dataclass(frozen=True)
class Finding:
    """One finding. ``where``: a joint, a link or the document; ``line``: its line; ``tried``: the paths that were searched."""

    severity: Severity
    where: str
    message: str
    line: int | None = None
    tried: tuple[str, ...] = ()


@dataclass(frozen=True)
class TreeRow:
    """A link in the picture of the tree: its depth, and its joint (None for a root)."""

    depth: int
    link: str
    joint: str | None = None
    type: str | None = None


@dataclass(frozen=True)
class Inspection:
    """The checks of a description. ``findings`` are sorted, worst first; ``tree`` has a row for each link, depth first.

    ``loads``: whether ``ulna.load`` accepts it; ``n_dof`` and ``reach`` [m] (of the longest chain, stretched) are None if not.
    ``closed_form``: the closed form of the hand's inverse kinematics, in words; empty without one.
    """

    source: str
    name: str
    loads: bool
    findings: tuple[Finding, ...]
    tree: tuple[TreeRow, ...]
    n_links: int = 0
    joint_types: dict[str, int] = field(default_factory=dict)
    n_dof: int | None = None
    reach: float | None = None
    closed_form: str = ""

    def count(self, severity: Severity) -> int:
        """The number of findings with a severity."""
        return sum(finding.severity == severity for finding in self.findings)

    @property
    def worst(self) -> Severity | None:
        """The worst severity present, or None."""
        return next((severity for severity in Severity if self.count(severity)), None)

    def __str__(self) -> str:
        lines = [f"{f.severity} {f.where}: {f.message}" for f in self.findings]
        return "\n".join([f"{self.source}: {'loads' if self.loads else 'cannot be loaded'}", *lines])


@dataclass(frozen=True)
class Difference:
    """One difference. ``kind``: one of ``KINDS``; ``where``: a joint or a link; ``a``, ``b``: the robots' values."""

    kind: str
    where: str
    a: str
    b: str


@dataclass(frozen=True)
class PoseDifference:
    """The largest distance [m] and angle [rad] between two corresponding links, over random configurations."""

    link_a: str
    link_b: str
    position: float
    rotation: float


@dataclass(frozen=True)
class Tolerances:
    """Differences that count as none: ``position`` [m], ``rotation`` [rad], and ``limit`` in a limit's own unit."""

    position: float = 1e-6
    rotation: float = 1e-6
    limit: float = 1e-6


@dataclass(frozen=True)
class Comparison:
    """The differences between two robots; ``same`` if there are none.

    ``poses`` has every pair of links, equal or not. Joints are matched by their names, or ``matched_by`` their order if few names
    are shared. Poses are in ``frame_a`` and ``frame_b``, at ``n_configurations`` random configurations.
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
        """The largest distance [m] between two corresponding links."""
        return max((pose.position for pose in self.poses), default=0.0)

    @property
    def max_rotation_difference(self) -> float:
        """The largest angle [rad] between two corresponding links."""
        return max((pose.rotation for pose in self.poses), default=0.0)

    def __str__(self) -> str:
        lines = [f"{d.kind} {d.where}: {d.a} | {d.b}" for d in self.differences]
        return "\n".join([f"{self.name_a} | {self.name_b}: {len(lines) or 'no'} difference{'s' * (len(lines) != 1)}", *lines])
