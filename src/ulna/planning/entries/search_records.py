"""Defines the settings, state, trees and path of a search, and the codes with which it ends."""

from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.lanes import WIDTH
from ulna.engine.records import Record, Records
from ulna.kernels.planning.constraint_records import Entry

RRT_CONNECT, AORRTC = 0, 1  # numbers of the algorithms
WITH_COSTS = (AORRTC,)  # the algorithms whose nodes have costs, and whose samples have one number more
# Codes of a call: solved; paused at its number of checks; no room for nodes; no sample left; an edge is not free; no room for the
# path.
SOLVED, PAUSED, FULL, NO_SAMPLE, NOT_FREE, NO_ROOM = 0, 1, 2, 3, 4, 5
# Codes of a step towards a configuration: not free; ended at another configuration on the constraints; reached.
STOPPED, BESIDE, REACHED = 0, 1, 2
MAX_REFUSED = 32  # number of refused edges that are recorded
SKIPPED_PER_CHECK = 64  # skipped samples that count as one checked edge, since they take about as long
# Maximum skipped samples in a row. In a narrow space with many joints, hardly any sample lies within the domains of a few nodes.
MAX_SKIPPED = 16
# Failed edges that halve a tree's steps towards samples, and the maximum number of halvings; a free edge resets them.
FAILURES_PER_HALF, MAX_HALVES = 128, 3
SHORTEN, CONFIRM = 0, 5  # the first pass of shortening, and the last, which confirms every edge
SPARE_POINTS = 128  # room to shorten a path, in addition to twice its points
RANGE = 1.0  # [rad]: maximum length of a tree's edge, for up to _FEW joints
_FEW = 8  # with more joints, samples are far from nodes and long edges seldom free: no domains, and shorter edges
_RESOLUTION = 1e-4  # [m]
SAMPLES_APART = 1 / 32  # [rad]: spacing of samples of an edge that is not certified
_DOMAIN, _MIN_DOMAIN, _ADAPTATION = 4.0, 1.0, 1e-4  # dynamic domain: radius and minimum in RANGE, for up to seven joints; rate
_MAX_STEPS = 4094  # maximum steps of one iteration


class SearchSettings(Record):
    """The read-only settings of a search."""

    range: float
    """Maximum length of a tree's edge, in the metric of the space."""
    resolution: float
    """Resolution of a certificate [m]."""
    margin: float
    """Minimum distance from an object of the world [m]."""
    sample_spacing: float
    """The spacing of the samples of an edge, in the metric; 0 if edges are certified."""
    domain: float
    """The radius of the domain of a node that could not be extended."""
    min_domain: float
    """The minimum radius of a domain."""
    adaptation: float
    """The rate of change of a radius."""
    bound: float
    """Upper bound of the cost of a path."""
    stride: float
    """Along constraints a step consists of strides: the maximum length of a stride."""
    max_strides: int
    """The maximum number of strides per step."""
    max_steps: int
    """The maximum number of steps towards a node in one iteration."""
    max_nodes: int
    """The maximum number of nodes that one iteration adds."""


@lru_cache(maxsize=64)
def search_settings(n_moving: int, diameter: float, margin: float, step: float, *, certify: bool) -> Records[SearchSettings]:
    """The settings of a search, shape (1,), read-only. step: maximum stride along constraints; infinite without any."""
    records = SearchSettings.records()
    settings, longest = records[0], RANGE * min(1.0, _FEW / max(1, n_moving))
    settings.range, settings.resolution, settings.margin = longest, _RESOLUTION, margin
    settings.sample_spacing = 0.0 if certify else SAMPLES_APART
    wide = RANGE * np.sqrt(max(1.0, n_moving / 7))  # grows like the distances between samples
    settings.domain = _DOMAIN * wide if n_moving <= _FEW else np.inf
    settings.min_domain, settings.adaptation = _MIN_DOMAIN * wide, _ADAPTATION
    settings.stride, settings.max_strides = min(longest, step), int(np.ceil(2.0 * longest / min(longest, step)))
    settings.max_steps = int(min(2 + np.ceil(diameter / longest), _MAX_STEPS))
    settings.max_nodes = (settings.max_steps + 2) * (WIDTH * settings.max_strides if step < np.inf else 1)
    records.setflags(write=False)
    return records


class SearchState(Record):
    """The state of a search, which may pause at any checked edge and continue in another call."""

    checks: int
    """The number of checked edges."""
    until: int
    """The number of checked edges at which this call pauses."""
    max_checks: int
    """The budget of the search in checked edges."""
    iterations: int
    """The number of samples towards which a tree was extended."""
    nodes: Annotated[NDArray[np.int64], 2]
    """The number of nodes of each tree: tree 0 grows from the start, tree 1 from the goals."""
    failures: Annotated[NDArray[np.int64], 2]
    """For each tree, the number of refused edges towards samples since the last free edge."""
    goal_roots: int
    """The number of goals, which are the first nodes of tree 1."""
    sample: int
    """The index of the next sample."""
    first_sample: int
    """The index of the first row of ``samples``."""
    skipped: int
    """The number of skipped samples."""
    skipped_in_a_row: int
    """The number of skipped samples since the last used one."""
    refused: int
    """The number of refused edges."""
    direct: int
    """The next node of tree 1 for the straight edge from the start."""
    active: int
    """The tree that grew last."""
    algorithm: int
    """The number of the algorithm, such as ``RRT_CONNECT``."""
    joined: bool
    """Whether the trees are joined."""
    joined_start: int
    """The node of tree 0 at which they are joined."""
    joined_goal: int
    """The node of tree 1 at which they are joined."""
    goal: int
    """The root of tree 1 that the path leads to; -1 without a path."""


class ShorteningState(Record):
    """The state of the shortening of a path, whose last pass confirms every edge."""

    checks: int
    """The number of checked edges."""
    until: int
    """The number of checked edges at which this call pauses."""
    points: int
    """The number of waypoints in use."""
    capacity: int
    """The maximum number of waypoints."""
    stage: int
    """The pass."""
    at: int
    """The position in the pass: a waypoint, or the number of an attempt."""
    target: int
    """Pass 1: the waypoint that is tried next; 0 for the last."""
    failures: int
    """Pass 2: the number of shortcuts along constraints that failed in a row."""
    halvings: int
    """Pass 3: the number of halvings of a corner's cut."""


# Entries take each of the following as one argument.
class SearchTables(NamedTuple):
    """The arguments of a search, without its trees."""

    settings: Records[SearchSettings]
    """The settings, shape (1,)."""
    space: Records[Entry]
    """The range of samples and the metric, shape (n_dof,)."""
    samples: NDArray
    """Random numbers in [0, 1), from sample ``first_sample``, shape (n, n_dof or more)."""
    state: Records[SearchState]
    """The state, shape (1,)."""


class Trees(NamedTuple):
    """The two trees of a search, with room for ``capacity`` nodes each, a multiple of 8.

    Tree 0 grows from the start, tree 1 from the goals.
    """

    rows: NDArray
    """The nodes in rows (``kernels.planning.space``), shape (2, capacity / 8 * n_dof, 8)."""
    parents: NDArray
    """The parent of each node, -1 for a root, shape (2, capacity)."""
    radii: NDArray
    """The radius of each node's domain, shape (2, capacity)."""
    costs: NDArray
    """The cost of each node, infinite in unused places, shape (2, capacity / 8, 8); (2, 0, 8) for algorithms without costs."""
    refused: NDArray
    """The last refused edges, as a ring buffer, shape (MAX_REFUSED, 2, n_dof)."""


class Path(NamedTuple):
    """A path with room to shorten it."""

    waypoints: NDArray
    """The waypoints, shape (capacity, n_dof)."""
    known: NDArray
    """1 if the edge from a waypoint is known to be free, else 0, shape (capacity,)."""
    spreads: NDArray
    """The distance from each edge in each joint that must be free too, shape (n - 1, n_dof), or (0, n_dof)."""
    state: Records[ShorteningState]
    """The state of its shortening, shape (1,)."""
