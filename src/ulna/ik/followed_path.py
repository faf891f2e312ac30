"""Holds a joint path through poses, or the reason why none was found."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ulna.ik.reason import Reason
from ulna.ik.solutions import Proof
from ulna.notebook.tables import OneLine

Array = NDArray[np.float64]


class PathStatus(StrEnum):
    """The outcome of a search for a joint path."""

    FOLLOWED = "followed"
    UNREACHABLE = "unreachable"
    LIMITS = "joint limits"
    COLLISION = "in collision"
    SINGULAR = "singular"
    NO_BRANCH = "no continuous branch"
    BUDGET_SPENT = "budget spent"


@dataclass(frozen=True)
class Ending:
    """The data of a ``Reason`` why no joint path continues to a pose.

    Attributes:
        status: The kind of reason.
        alive: The number of known configurations in which a path to the previous pose ends.
        smallest_step: The smallest joint step from these to a valid solution of the pose [rad or m], with the whole turns that
            the limits allow; infinite if none is known.
        manipulability: At the end of the path; for the first pose, at the start.
        least_singular_value: The smallest singular value of the Jacobian there, as a share of the largest.
        limit_excess: The excess of each joint over its limit [rad or m], shape (n_dof,); 0 unless limits are the reason.
        collisions: The pairs in contact, with their depths [m]: (name_a, name_b, depth).
    """

    status: PathStatus
    alive: int
    smallest_step: float
    manipulability: float
    least_singular_value: float
    limit_excess: Array
    collisions: tuple[tuple[str, str, float], ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class FollowedPath(OneLine):
    """The joint path through poses (n, 4, 4), or its beginning. ``bool(path)`` is True if every pose is reached.

    ======================== =========================================================================================
    ``followed``             Every pose is reached, and no joint takes a longer step than ``max_step``, from ``q_start`` on.
    ``unreachable``          The pose has no solution.
    ``joint limits``         A path continues only beyond the limits; ``reason.data.limit_excess`` holds the excess. Or the
                             pose has solutions, all beyond the limits. Or ``q_start`` is beyond the limits, and the first
                             pose is not near the nearest configuration within them.
    ``in collision``         A path continues only in collision; ``reason.data.collisions`` names the pairs.
    ``singular``             The arm is nearly singular, and only the part of the step along its weakest direction makes it
                             too long.
    ``no continuous branch`` None of these: all solutions of the pose are more than a step away, or in turns that were not
                             searched; ``reason`` gives details.
    ``budget spent``         ``time_limit`` was over before a path to the pose was found.
    ======================== =========================================================================================

    Attributes:
        q: Joint positions [rad or m], shape (n, n_dof), always within the limits; NaN from the first unreached pose on.
        q_start: The configuration before the first pose, within the limits, shape (n_dof,); None if it was not given.
        max_step: The largest allowed step [rad or m].
        ends_at: The index of the first pose without a path; None if all are reached.
        reason: The reason why the path ends, with an ``Ending`` as its data; no reason if all poses are reached.
        proof: ``complete``: the closed form compared every solution of every pose. No path with steps up to ``max_step`` has a
            lower cost; if none is found, none exists. ``searched``: it is the best path found.
    """

    q: Array
    q_start: Array | None
    max_step: float
    ends_at: int | None
    reason: Reason
    proof: Proof
    joint_names: tuple[str, ...] = field(repr=False, default=())

    def __post_init__(self) -> None:
        self.q.setflags(write=False)
        if self.q_start is not None:
            self.q_start.setflags(write=False)

    def __bool__(self) -> bool:
        return self.success

    @property
    def success(self) -> bool:
        """Whether every pose is reached."""
        return self.ends_at is None

    @property
    def status(self) -> PathStatus:
        """The outcome of the search; see above."""
        return self.reason.data.status if self.reason else PathStatus.FOLLOWED

    @property
    def steps(self) -> Array:
        """The largest step of any joint to each pose [rad or m]; NaN without a path.

        With ``q_start``, the first step leads from it to the first pose, shape (n,). Without it, from the first pose to the
        second, shape (n - 1,).
        """
        every = self.q if self.q_start is None else np.vstack([self.q_start, self.q])
        return np.abs(np.diff(every, axis=0)).max(axis=1, initial=0.0) if self.q.shape[1] else np.zeros(len(every) - 1)

    def __str__(self) -> str:
        if not self.reason:
            longest = float(self.steps.max(initial=0.0))
            return f"followed: {len(self.q)} pose{'s' * (len(self.q) != 1)}, largest joint step {longest:.3g} ({self._proved()})"
        return f"{self.status} at pose {self.ends_at} of {len(self.q)}: {self.reason} ({self._proved()})"

    def _proved(self) -> str:
        if not self.reason:
            return "proved best" if self.proof is Proof.COMPLETE else "best found"
        return "proved" if self.proof is Proof.COMPLETE else "not proved"
