"""Names how a search for a plan ended, says why, and holds what it took."""

from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum

from ulna.collision.report import Pair, Report
from ulna.ik.reason import Reason

_MOST_PAIRS = 4  # that a sentence names


class PlanStatus(StrEnum):
    """How a search for a plan ended."""

    SOLVED = "solved"
    START_IN_COLLISION = "start in collision"
    START_BEYOND_LIMITS = "start beyond limits"
    GOAL_IN_COLLISION = "goal in collision"
    GOAL_UNREACHABLE = "goal unreachable"
    BUDGET_SPENT = "budget spent"


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


def in_collision(report: Report, margin: float, clouds: Collection[str] = ()) -> Reason:
    """The pairs that touch, or are nearer than a margin [m]; clouds: which objects of the world are point clouds."""
    own = all(pair.link_b is not None for pair in report.pairs)
    hint = "; if these shapes touch wherever the robot is, allow the pairs (docs/self_collision.md)" if own else ""
    seen = dict.fromkeys(pair.name_b for pair in report.pairs if pair.link_b is None and pair.name_b in clouds)
    for name in seen:
        hint += f"; {name} is a point cloud: if the points are those of the robot, cloud.without(robot, q) removes them"
    more = f" and {len(report.pairs) - _MOST_PAIRS} more pairs" if len(report.pairs) > _MOST_PAIRS else ""
    return Reason(", ".join(_in_words(pair, margin) for pair in report.pairs[:_MOST_PAIRS]) + more + hint, report)


def _in_words(pair: Pair, margin: float) -> str:
    distance = pair.signed_distance * 1e3
    if distance > 0.0:
        return f"{pair.name_a} is {distance:.3g} mm from {pair.name_b}, nearer than {margin * 1e3:.3g} mm"
    return (
        f"{pair.name_a} and {pair.name_b} ({-distance:.3g} mm deep)" if distance < 0.0 else f"{pair.name_a} touches {pair.name_b}"
    )
