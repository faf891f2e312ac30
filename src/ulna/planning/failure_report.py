"""Reports why a search found no path: the limit that ended it, and the contacts of its last refused edges."""

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.errors import count_of
from ulna.ik.reason import Reason
from ulna.planning.constraint_table import satisfy_constraints, shrink_tolerances
from ulna.planning.goals import Request
from ulna.planning.motion import Motion
from ulna.planning.search import Effort
from ulna.planning.space import sample_line

Array = NDArray[np.float64]
_SPACING = 1 / 32  # [rad]: spacing of the samples of a refused edge that are checked for contacts
_MAX_NAMED = 3  # pairs named in a message


class Stop(NamedTuple):
    """A pair whose contact blocked edges.

    Attributes:
        link: A link of the robot, or an attached object.
        other: Another link or attached object, or an object of the world.
        of_robot: Whether both belong to the robot.
        edges: The number of edges that the pair blocked.
    """

    link: str
    other: str
    of_robot: bool
    edges: int


@dataclass(frozen=True)
class SpentBudget:
    """The report of a search that ended without a path.

    Attributes:
        limit: The option that ended it: ``"max_checks"`` or ``"time_limit"``.
        effort: The effort of the search.
        edges: The number of refused edges that were examined: the last ones, at most 32.
        stops: The pairs that blocked them, most frequent first. An edge that two pairs block at one sample counts for both.
        uncertified: The number of these edges that could not be certified but are free at samples; ``certify=False`` accepts
            them.
        not_kept: The number of these edges that violate the constraints.
    """

    limit: str
    effort: Effort
    edges: int
    stops: tuple[Stop, ...]
    uncertified: int
    not_kept: int = 0


def report_spent_budget(request: Request, motion: Motion, edges: Array, effort: Effort, limit: str, *, certify: bool) -> Reason:
    """The reason for a search without a path. limit: the option that ended it, with its value, as in ``"time_limit=10"``.

    edges: the last refused edges, shape (n, 2, n_dof).
    """
    at_samples = motion.edges(certify=False)
    passed = np.array([certify and at_samples.checked(edge) is not None for edge in edges], dtype=bool)
    kept = satisfy_constraints(shrink_tolerances(motion.keeps), request.tree, edges[:, 0], edges[:, 1])
    stops = _find_stops(request, edges[~passed & kept])
    found = SpentBudget(limit.partition("=")[0], effort, len(edges), stops, int(passed.sum()), int((~kept).sum()))
    reached = (
        f"after {count_of(effort.checks, 'checked edge')} ({limit}); "
        f"{count_of(effort.start_nodes, 'configuration was', 'configurations were')} reached from the start, "
        f"{effort.goal_nodes} from the goals, and no edge between them was found"
    )
    return Reason(reached + _describe_refused(found), found)


def _describe_refused(found: SpentBudget) -> str:
    """The sentences about the refused edges."""
    pairs = ", ".join(f"{stop.link} and {stop.other} ({stop.edges})" for stop in found.stops[:_MAX_NAMED])
    sentence = f". Pairs that blocked the last {count_of(found.edges, 'refused edge')}: {pairs}" if pairs else ""
    if found.not_kept:
        sentence += f". {found.not_kept} of the last {found.edges} refused edges violate the constraints"
    if found.uncertified:
        sentence += (
            f". {found.uncertified} of the last {found.edges} refused edges are free at samples, but could not be certified"
        )
        sentence += "; certify=False accepts them"
    if 2 * sum(stop.edges for stop in found.stops if stop.of_robot) > found.edges:
        sentence += ". If these links touch in every configuration, allow the pairs (docs/self_collision.md)"
    return sentence


def _find_stops(request: Request, edges: Array) -> tuple[Stop, ...]:
    """The pairs that touch at the first colliding sample of each edge, shape (n, 2, n_dof), with counts."""
    counts: Counter[tuple[str, str, bool]] = Counter()
    for a, b in edges:
        q = sample_line(a, b, _SPACING)
        free = request.is_free(q)
        if not free.all():
            touching = request.touching(q[free.argmin()])
            counts.update({(pair.link_a, pair.link_b or pair.name_b, pair.link_b is not None) for pair in touching})
    return tuple(Stop(*pair, edges) for pair, edges in sorted(counts.items(), key=lambda item: (-item[1], item[0])))
