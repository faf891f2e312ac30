"""Names how a search for a plan ended. Used by ``plan``, ``planner`` and ``goals``."""

from enum import StrEnum


class PlanStatus(StrEnum):
    """How a search for a plan ended."""

    SOLVED = "solved"
    START_IN_COLLISION = "start in collision"
    START_BEYOND_LIMITS = "start beyond limits"
    GOAL_IN_COLLISION = "goal in collision"
    GOAL_UNREACHABLE = "goal unreachable"
    BUDGET_SPENT = "budget spent"
