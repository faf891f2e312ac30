"""Defines the settings of a search for a path, and names what it counts, how it ends, and what it has found."""

from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.lanes import WIDTH
from ulna.engine.records import Record, Records
from ulna.kernels.planning.constraint_records import Entry

RRT_CONNECT, AORRTC = 0, 1  # numbers of the algorithms
WITH_COSTS = (AORRTC,)  # the algorithms whose nodes have costs, and whose samples have one number more
# How a call ends: solved; paused at its number of checks; no room for more nodes; no sample left; an edge that is not free; no
# room for the path.
SOLVED, PAUSED, FULL, NO_SAMPLE, NOT_FREE, NO_ROOM = 0, 1, 2, 3, 4, 5
# How a step towards a configuration ends: not free; at another configuration, which keeps the constraints; there.
STOPPED, BESIDE, REACHED = 0, 1, 2
MAX_REFUSED = 32  # of the edges that were not free, so many are kept
SKIPPED_PER_CHECK = 64  # samples that were skipped count as one checked edge: they take about as long
# After so many skipped samples the next is tried wherever it is: where a tree is hemmed in and joints are many, hardly any sample
# lies within the domains of its few nodes.
MAX_SKIPPED = 16
# So many failed edges halve the steps of a tree towards samples, so often; a free edge makes them long again.
FAILURES_PER_HALF, MAX_HALVES = 128, 3
SHORTEN, CONFIRM = 0, 5  # the first pass of shortening, and the last, which confirms every edge
SPARE_POINTS = 128  # besides twice the points of a path: room to shorten it
_RANGE = 1.0  # the longest edge of a tree [rad], for up to _FEW joints
_FEW = 8  # of more joints most samples are far from every node, and fewer long edges are free: no domains, and shorter edges
_RESOLUTION = 1e-4  # [m]
_SAMPLES_APART = 1 / 32  # [rad]: of an edge that is not certified
_DOMAIN, _MIN_DOMAIN, _ADAPTATION = 4.0, 1.0, 1e-4  # times _RANGE, for up to seven joints; and the rate
_MAX_STEPS = 4094  # of one iteration


class SearchSettings(Record):
    """Settings of a search, which are only read."""

    range: float
    """The longest edge of a tree, in the metric of the space."""
    resolution: float
    """Resolution of a certificate [m]."""
    margin: float
    """Smallest distance that is allowed to an object of the world [m]."""
    sample_spacing: float
    """0: edges are certified; else the spacing of the samples of an edge, in the metric."""
    domain: float
    """The radius of a node that could not be extended; ``min_domain``: its least value, ``adaptation``: its rate of change."""
    min_domain: float
    adaptation: float
    bound: float
    """Upper bound of the cost: a path is found only if it costs less."""
    stride: float
    """Along constraints a step is made of strides: how long one may be, and ``max_strides``: how many there may be."""
    max_strides: int
    max_steps: int
    """Largest number of steps towards a node in one iteration; ``max_nodes``: of nodes that it adds."""
    max_nodes: int


@lru_cache(maxsize=64)
def search_settings(n_moving: int, diameter: float, margin: float, step: float, *, certify: bool) -> Records[SearchSettings]:
    """Settings of a search, shape (1,), which are only read. step: the longest stride along constraints; infinite without any."""
    records = SearchSettings.records()
    settings, longest = records[0], _RANGE * min(1.0, _FEW / max(1, n_moving))
    settings.range, settings.resolution, settings.margin = longest, _RESOLUTION, margin
    settings.sample_spacing = 0.0 if certify else _SAMPLES_APART
    wide = _RANGE * np.sqrt(max(1.0, n_moving / 7))  # as the distances of samples grow
    settings.domain = _DOMAIN * wide if n_moving <= _FEW else np.inf
    settings.min_domain, settings.adaptation = _MIN_DOMAIN * wide, _ADAPTATION
    settings.stride, settings.max_strides = min(longest, step), int(np.ceil(2.0 * longest / min(longest, step)))
    settings.max_steps = int(min(2 + np.ceil(diameter / longest), _MAX_STEPS))
    settings.max_nodes = (settings.max_steps + 2) * (WIDTH * settings.max_strides if step < np.inf else 1)
    records.setflags(write=False)
    return records


class SearchState(Record):
    """State of a search. It may be paused at any checked edge and go on in another call."""

    checks: int
    """Number of edges checked; ``until``: number at which this call pauses, ``max_checks``: budget of the search."""
    until: int
    max_checks: int
    iterations: int
    """Number of samples towards which a node stepped."""
    nodes: Annotated[NDArray[np.int64], 2]
    """Number of nodes of each tree: tree 0 grows from the start, tree 1 from the goals."""
    failures: Annotated[NDArray[np.int64], 2]
    """For each tree, the number of edges towards samples that were not free since the last free one."""
    goal_roots: int
    """Number of goals, which are the first nodes of tree 1."""
    sample: int
    """Index of the next sample; ``first_sample``: index of the first row of ``samples``."""
    first_sample: int
    skipped: int
    """Number of samples skipped; ``skipped_in_a_row``: number since the last one that was used."""
    skipped_in_a_row: int
    refused: int
    """Number of edges that were not free."""
    direct: int
    """The next node of tree 1 to which the straight edge from the start is tried."""
    active: int
    """The tree that grew last."""
    algorithm: int
    """Number of the algorithm, such as ``RRT_CONNECT``."""
    joined: bool
    """Whether the trees are joined: at ``joined_start`` of tree 0 and ``joined_goal`` of tree 1."""
    joined_start: int
    joined_goal: int
    goal: int
    """The root of tree 1 that the path leads to; -1 before there is one."""


class ShorteningState(Record):
    """State of the shortening of a path. The last pass confirms every edge."""

    checks: int
    """Number of edges checked; ``until``: number at which this call pauses."""
    until: int
    points: int
    """Number of waypoints in use; ``capacity``: largest number."""
    capacity: int
    stage: int
    """The pass."""
    at: int
    """Position in the pass: a waypoint, or the number of an attempt."""
    target: int
    """Pass 1: the waypoint that is tried next; 0 for the last."""
    failures: int
    """Pass 2: number of short cuts along constraints that failed in a row."""
    halvings: int
    """Pass 3: number of times that the cut of a corner was halved."""


# An entry takes each of these whole.
class SearchTables(NamedTuple):
    """A search, without its trees."""

    settings: Records[SearchSettings]
    """Shape (1,)."""
    space: Records[Entry]
    """Where samples are taken from, and how lengths are measured, shape (n_dof,)."""
    samples: NDArray
    """Numbers in [0, 1), the first row that of number ``first_sample``, shape (n, n_dof or more)."""
    state: Records[SearchState]
    """Shape (1,)."""


class Trees(NamedTuple):
    """The two trees of a search: tree 0 from the start, tree 1 from the goals. Room for ``capacity`` nodes, a multiple of 8."""

    rows: NDArray
    """The nodes (``space``), shape (2, capacity / 8 * n_dof, 8)."""
    parents: NDArray
    """Parent of each node, -1 for a root, shape (2, capacity)."""
    radii: NDArray
    """Radius of each node's domain, shape (2, capacity)."""
    costs: NDArray
    """The cost to reach each node, infinite in unused places, shape (2, capacity / 8, 8); (2, 0, 8) where nodes have no costs."""
    refused: NDArray
    """The last edges that were not free, in a ring, shape (MAX_REFUSED, 2, n_dof)."""


class Path(NamedTuple):
    """A path that was found, with room to shorten it."""

    waypoints: NDArray
    """Shape (capacity, n_dof)."""
    known: NDArray
    """1 where the edge from a waypoint was found free as it is, else 0, shape (capacity,)."""
    spreads: NDArray
    """Width beside each edge that must be free too, one number a joint, shape (n - 1, n_dof), or (0, n_dof)."""
    state: Records[ShorteningState]
    """Shape (1,)."""
