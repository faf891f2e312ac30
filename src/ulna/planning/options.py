"""Checks the options of a plan."""

from dataclasses import dataclass
from functools import lru_cache
from numbers import Real
from typing import Any

import numpy as np

from ulna.errors import InputError

MAX_CHECKS = 100_000


@dataclass(frozen=True)
class PlanOptions:
    """How a plan is searched for, checked.

    Attributes:
        certify: Whether edges are certified, or checked at samples.
        clearance: How near an object may be [m].
        seed: Chooses the samples.
        max_checks: How many edges are checked at most.
        shorten: Whether the path is shortened.
        escape: Whether a start that touches a little is left.
        time_limit: How long the search may take [s].

    Raises:
        InputError: One of them cannot be taken; its name is in the message.
    """

    certify: bool = True
    clearance: float = 0.0
    seed: int = 0
    max_checks: int = MAX_CHECKS
    shorten: bool = True
    escape: bool = False
    time_limit: float | None = None

    def __post_init__(self) -> None:
        for name in ("certify", "shorten", "escape"):
            if not isinstance(getattr(self, name), bool | np.bool_):
                raise InputError(name, f"{getattr(self, name)!r}; True or False is expected")
        refuse_unless("clearance", self.clearance, 0.0, "a distance [m] of at least 0")
        refuse_unless_count("seed", self.seed, 0)
        refuse_unless_count("max_checks", self.max_checks, 1)
        if self.time_limit is not None:
            refuse_unless("time_limit", self.time_limit, 0.0, "a time [s] above 0", above=True)


@lru_cache(maxsize=64, typed=True)
def _kept(*options: Any) -> PlanOptions:
    return PlanOptions(*options)


def as_options(*options: Any) -> PlanOptions:
    """The options of a plan, checked once: those of recent calls are kept.

    Raises:
        InputError: One of them cannot be taken; its name is in the message.
    """
    try:
        hash(options)
    except TypeError:
        return PlanOptions(*options)
    return _kept(*options)


def refuse_unless(name: str, value: Any, least: float, expected: str, *, above: bool = False) -> None:
    """Refuse what is not a finite number of at least ``least``, or above it.

    Raises:
        InputError: It is not; ``name`` and ``expected`` are in the message.
    """
    good = (
        isinstance(value, Real)
        and not isinstance(value, bool)
        and least <= float(value) < np.inf
        and not (above and value == least)
    )
    if not good:
        raise InputError(name, f"{value!r}; {expected} is expected")


def refuse_unless_count(name: str, value: Any, least: int) -> None:
    """Refuse what is not a whole number of at least ``least``.

    Raises:
        InputError: It is not; ``name`` is in the message.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value < 2**62:
        raise InputError(name, f"{value!r}; a whole number of at least {least} is expected")
