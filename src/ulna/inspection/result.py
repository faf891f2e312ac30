"""Holds the result of an inspection, as frozen data."""

from dataclasses import dataclass, field
from enum import StrEnum


class Severity(StrEnum):
    """How bad a finding is.

    ``ERROR``: refused, or a contradiction. ``WARNING``: it works, and is probably not what was meant.
    ``NOTE``: good to know.
    """

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One finding. ``where`` is a joint, a link or the document; ``line`` its line; ``tried`` the paths that were looked at."""

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
    """The health of a description. ``findings`` are sorted, worst first, ``tree`` has a row for each link, depth first.

    ``loads``: whether ``ulna.load`` takes it; ``n_dof`` and ``reach`` [m] (of the longest chain, stretched) are None if not.
    ``closed_form``: that of the hand's inverse kinematics, in words; empty if there is none.
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
        """How many findings of a severity there are."""
        return sum(finding.severity == severity for finding in self.findings)

    @property
    def worst(self) -> Severity | None:
        """The worst severity there is, or None."""
        return next((severity for severity in Severity if self.count(severity)), None)

    def __str__(self) -> str:
        lines = [f"{f.severity} {f.where}: {f.message}" for f in self.findings]
        return "\n".join([f"{self.source}: {'loads' if self.loads else 'cannot be loaded'}", *lines])
