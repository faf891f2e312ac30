"""Holds the request of a caller of inverse kinematics, and its options, which are validated here."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ulna.collision.world import World
from ulna.description.arrays import as_count, as_number, as_switch, positive
from ulna.errors import InputError, did_you_mean
from ulna.ik.task import Task, as_task

POSE = Task.pose()
_AT_LEAST_0 = 0.0, "a number of at least 0"
RANKS = ("nearest", "manipulability", "clearance", "mid_range")
TOLERANCE = 1e-5  # of an error [m or rad]
N_SAMPLES = 16  # positions of a held joint
DEFAULT_BUDGET = 16_000  # steps of all starts together: 800 starts


class Options(NamedTuple):
    """The arguments of ``Robot.inverse_kinematics`` except targets, configurations and world; documented there.

    Their defaults are those of every search. They are unvalidated until ``checked()``.
    """

    seed: int = 0
    task: Any = POSE  # a Task, or its name until checked
    rank: str | None = None
    position_tolerance: float = TOLERANCE
    rotation_tolerance: float = TOLERANCE
    max_step: float | None = None
    max_iterations: int | None = None
    time_limit: float | None = None
    trace: bool = False

    def checked(self) -> "Options":
        """Validate the options: the task as a ``Task``, numbers as Python's own types."""
        if self.rank is not None and (not isinstance(self.rank, str) or self.rank not in RANKS):
            raise InputError("rank", f"{self.rank!r} is not a rank{did_you_mean(str(self.rank), RANKS)}")
        return self._replace(
            seed=as_count("seed", self.seed),
            task=as_task(self.task),
            max_step=None if self.max_step is None else positive("max_step", self.max_step),
            position_tolerance=positive("position_tolerance", self.position_tolerance),
            rotation_tolerance=positive("rotation_tolerance", self.rotation_tolerance),
            max_iterations=None if self.max_iterations is None else as_count("max_iterations", self.max_iterations),
            time_limit=None if self.time_limit is None else as_number("time_limit", self.time_limit, *_AT_LEAST_0, most=np.inf),
            trace=as_switch("trace", self.trace),
        )

    @property
    def budget(self) -> int:
        """The steps of all starts together."""
        return DEFAULT_BUDGET if self.max_iterations is None else self.max_iterations

    @property
    def tolerances(self) -> tuple[float, float]:
        """Maximum errors that count as reached [m, rad]."""
        return self.position_tolerance, self.rotation_tolerance


DEFAULTS = Options()


class Request(NamedTuple):
    """One call of ``Robot.inverse_kinematics``, as the caller made it; its arguments are documented there."""

    T: ArrayLike
    q_seed: ArrayLike | None = None
    posture: ArrayLike | str | None = None
    held: tuple[str, ...] = ()
    world: World | None = None
    link: str | None = None
    options: Options = DEFAULTS
