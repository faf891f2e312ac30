"""Holds what a search for a plan took. Used by ``search`` and ``plan``."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """What a search took.

    Attributes:
        checks: How many edges were checked.
        iterations: How many samples a node stepped towards; the others were outside its domain.
        start_nodes: How many configurations were reached from the start.
        goal_nodes: How many the goals were reached from.
    """

    checks: int = 0
    iterations: int = 0
    start_nodes: int = 0
    goal_nodes: int = 0

    def plus(self, other: "Effort") -> "Effort":
        """The sum of two searches; the nodes are those of the larger trees."""
        nodes = max(self.start_nodes, other.start_nodes), max(self.goal_nodes, other.goal_nodes)
        return Effort(self.checks + other.checks, self.iterations + other.iterations, *nodes)
