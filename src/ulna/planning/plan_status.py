"""Names how a search for a plan ended, and says why. Used by ``plan``, ``planner`` and ``goals``."""

from enum import StrEnum

from ulna.collision.report import Pair, Report
from ulna.ik.reason import Reason
from ulna.planning.effort import Effort

_MOST_PAIRS = 4  # that a sentence names


class PlanStatus(StrEnum):
    """How a search for a plan ended."""

    SOLVED = "solved"
    START_IN_COLLISION = "start in collision"
    START_BEYOND_LIMITS = "start beyond limits"
    GOAL_IN_COLLISION = "goal in collision"
    GOAL_UNREACHABLE = "goal unreachable"
    BUDGET_SPENT = "budget spent"


def in_collision(report: Report, margin: float) -> Reason:
    """The pairs that touch, or are nearer than a margin [m]."""
    own = all(pair.link_b is not None for pair in report.pairs)
    hint = "; if these shapes touch wherever the robot is, allow the pairs (docs/self_collision.md)" if own else ""
    more = f" and {len(report.pairs) - _MOST_PAIRS} more pairs" if len(report.pairs) > _MOST_PAIRS else ""
    return Reason(", ".join(_in_words(pair, margin) for pair in report.pairs[:_MOST_PAIRS]) + more + hint, report)


def _in_words(pair: Pair, margin: float) -> str:
    distance = pair.signed_distance * 1e3
    if distance > 0.0:
        return f"{pair.name_a} is {distance:.3g} mm from {pair.name_b}, nearer than {margin * 1e3:.3g} mm"
    return (
        f"{pair.name_a} and {pair.name_b} ({-distance:.3g} mm deep)" if distance < 0.0 else f"{pair.name_a} touches {pair.name_b}"
    )


def budget_spent(effort: Effort) -> Reason:
    """How far the search came."""
    return Reason(
        f"after {effort.checks} checked edges; {effort.start_nodes} configurations were reached from the start, "
        f"{effort.goal_nodes} from the goals, and no edge between them was found",
        effort,
    )
