"""Holds and checks what a caller may choose about a search, whatever the targets."""

from typing import Any, NamedTuple

import numpy as np

from ulna.description.arrays import as_count, as_number, as_switch, positive
from ulna.errors import InputError, did_you_mean
from ulna.ik.task import Task, as_task

LEVENBERG_MARQUARDT = "levenberg_marquardt"
TEXTBOOK = ("jacobian_transpose", "damped_least_squares", "pseudo_inverse")
POSE = Task.pose()
METHODS = (LEVENBERG_MARQUARDT, *TEXTBOOK)
_AT_LEAST_0 = 0.0, "a number of at least 0"
RANKS = ("nearest", "manipulability", "clearance", "mid_range")
DEFAULT_BUDGET, TEXTBOOK_BUDGET = 16_000, 10_000  # steps of all starts together: 800 starts


class Options(NamedTuple):
    """The arguments of ``Robot.inverse_kinematics`` that are neither targets, configurations nor a world; documented there.

    Their defaults are those of every search. They are what the caller gave, whatever that is, until they are ``checked``.
    """

    seed: int = 0
    task: Any = POSE  # a Task; or its name, unless checked
    rank: str | None = None
    position_tolerance: float = 1e-5
    rotation_tolerance: float = 1e-5
    threads: int | None = None
    method: str = LEVENBERG_MARQUARDT
    max_step: float | None = None
    max_iterations: int | None = None
    time_limit: float | None = None
    trace: bool = False

    def checked(self) -> "Options":
        """These options, the task as a ``Task`` and the others as Python's own numbers."""
        if not isinstance(self.method, str) or self.method not in METHODS:
            raise InputError("method", f"{self.method!r} is not a method{did_you_mean(str(self.method), METHODS)}")
        if self.rank is not None and (not isinstance(self.rank, str) or self.rank not in RANKS):
            raise InputError("rank", f"{self.rank!r} is not a rank{did_you_mean(str(self.rank), RANKS)}")
        options = self._replace(
            seed=as_count("seed", self.seed),
            task=as_task(self.task),
            max_step=None if self.max_step is None else positive("max_step", self.max_step),
            position_tolerance=positive("position_tolerance", self.position_tolerance),
            rotation_tolerance=positive("rotation_tolerance", self.rotation_tolerance),
            max_iterations=None if self.max_iterations is None else as_count("max_iterations", self.max_iterations),
            time_limit=None if self.time_limit is None else as_number("time_limit", self.time_limit, *_AT_LEAST_0, most=np.inf),
            threads=None if self.threads is None else as_count("threads", self.threads),
            trace=as_switch("trace", self.trace),
        )
        if options.is_textbook:
            for name in ("rank", "time_limit"):
                if getattr(options, name) is not None:
                    raise options.refused_by_textbook(name)
        return options

    @property
    def is_textbook(self) -> bool:
        """Whether the method searches from the seed alone."""
        return self.method in TEXTBOOK

    @property
    def budget(self) -> int:
        """The steps of all starts together."""
        if self.max_iterations is not None:
            return self.max_iterations
        return TEXTBOOK_BUDGET if self.is_textbook else DEFAULT_BUDGET

    @property
    def tolerances(self) -> tuple[float, float]:
        """Largest errors that count as reached [m, rad]."""
        return self.position_tolerance, self.rotation_tolerance

    def refused_by_textbook(self, name: str) -> InputError:
        """The error for an argument that the textbook methods do not take."""
        return InputError(name, f"the method {self.method!r} takes none: it goes from the seed alone, wherever that leads")
