"""Says what stopped a search that found no path: which limit ended it, and what its last refused edges touch."""

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.ik.reason import Reason
from ulna.planning.goals import Request
from ulna.planning.motion import Motion
from ulna.planning.plan_status import Effort
from ulna.planning.search import Search

Array = NDArray[np.float64]
_SAMPLES = 32  # of a refused edge, at which what touches is looked for; a long one may pass a thin object between them
_MOST_NAMED = 3  # pairs in a sentence


class Stop(NamedTuple):
    """What stopped some edges.

    Attributes:
        link: A link of the robot, or an attached object.
        other: Another one, or an object of the world.
        of_robot: Whether both are the robot's.
        edges: How many edges these two stopped.
    """

    link: str
    other: str
    of_robot: bool
    edges: int


@dataclass(frozen=True)
class SpentBudget:
    """How a search without a path ended, and what stopped its last refused edges.

    Attributes:
        limit: Which option ended it: ``"max_checks"`` or ``"time_limit"``.
        effort: How far it came.
        edges: How many refused edges were looked at: the last ones, at most 32.
        stops: What stopped them, the most frequent first. An edge that two pairs stop at one place counts for both.
        uncertified: How many of them could not be certified, but are free at samples: ``certify=False`` would have passed them.
    """

    limit: str
    effort: Effort
    edges: int
    stops: tuple[Stop, ...]
    uncertified: int


def budget_spent(request: Request, motion: Motion, search: Search, limit: str, *, certify: bool) -> Reason:
    """Why a search ended without a path; ``limit`` is that option with its value, as in ``"time_limit=10"``."""
    edges, effort = search.refused, search.effort
    passed = np.array([certify and _passes_at_samples(motion, edge) for edge in edges], dtype=bool)
    found = SpentBudget(limit.partition("=")[0], effort, len(edges), _stops(request, edges[~passed]), int(passed.sum()))
    reached = (
        f"after {effort.checks} checked edges ({limit}); {effort.start_nodes} configurations were reached from the start, "
        f"{effort.goal_nodes} from the goals, and no edge between them was found"
    )
    return Reason(reached + _of_refused(found), found)


def _of_refused(found: SpentBudget) -> str:
    """What is said of the refused edges."""
    pairs = ", ".join(f"{stop.link} and {stop.other} ({stop.edges})" for stop in found.stops[:_MOST_NAMED])
    sentence = f". What stopped the last {found.edges} refused edges: {pairs}" if pairs else ""
    if found.uncertified:
        sentence += (
            f". {found.uncertified} of the last {found.edges} refused edges are free at samples, but could not be certified"
        )
        sentence += ": certify=False would have passed them"
    if 2 * sum(stop.edges for stop in found.stops if stop.of_robot) > found.edges:
        sentence += ". If these links touch wherever the robot is, allow the pairs (docs/self_collision.md)"
    return sentence


def _passes_at_samples(motion: Motion, edge: Array) -> bool:
    return motion.edges(certify=False).confirmed(edge)[0] is not None


def _stops(request: Request, edges: Array) -> tuple[Stop, ...]:
    """What touches at the first sample of each edge, shape (n, 2, n_dof), at which something does."""
    if not len(edges):
        return ()
    share = np.linspace(0.0, 1.0, _SAMPLES + 1)[1:, None]
    q = edges[:, :1] + share * (edges[:, 1:] - edges[:, :1])
    free = request.is_free(q.reshape(-1, q.shape[2])).reshape(q.shape[:2])
    counts: Counter[tuple[str, str, bool]] = Counter()
    for k in np.flatnonzero(~free.all(axis=1)):
        pairs = request.collision(q[k, free[k].argmin()]).data.pairs
        counts.update({(pair.link_a, pair.link_b or pair.name_b, pair.link_b is not None) for pair in pairs})
    return tuple(Stop(*pair, edges) for pair, edges in sorted(counts.items(), key=lambda item: (-item[1], item[0])))
