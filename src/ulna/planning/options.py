"""Holds and checks what a caller may choose about a plan, whatever the start and the goal."""

import math
from typing import NamedTuple

from ulna.description.arrays import as_count, as_number, as_switch

MOST_CHECKS = 2**62 - 1


class PlanOptions(NamedTuple):
    """The options of ``Robot.plan`` that say how a path is searched for; documented there.

    Their defaults are those of every plan. They are what the caller gave, whatever that is, until they are ``checked``.
    """

    certify: bool = True
    clearance: float = 0.0
    seed: int = 0
    max_checks: int = 100_000
    shorten: bool = True
    escape: bool = False
    time_limit: float | None = 10.0

    def checked(self) -> "PlanOptions":
        """These options as Python's own numbers."""
        return PlanOptions(
            as_switch("certify", self.certify),
            as_number("clearance", self.clearance, 0.0, "a distance [m] of at least 0"),
            as_count("seed", self.seed, most=MOST_CHECKS),
            as_count("max_checks", self.max_checks, 1, MOST_CHECKS),
            as_switch("shorten", self.shorten),
            as_switch("escape", self.escape),
            as_time_limit(self.time_limit),
        )


def as_time_limit(time_limit: object) -> float | None:
    """The longest time of a search [s]; None or infinity for no limit."""
    expected = "a time [s] above 0, or None for no limit,"
    return None if time_limit is None else as_number("time_limit", time_limit, 0.0, expected, above=True, most=math.inf)
