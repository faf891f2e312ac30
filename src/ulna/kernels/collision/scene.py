"""Names the parts of a robot and a world as the kernels and the entries take them, and of what these find."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record
from ulna.engine.signatures import MATRIX, NONE, PAIRS, TABLE, TRUTH_TABLE, WHOLE, Group


class Scene(NamedTuple):
    """A robot and the objects of a world, in flat arrays (columns: ``kernels.layout``).

    Where all shapes are boxes, ``vertices`` and ``points`` are None: such scenes compile without the search for distances of
    convex shapes, in a fraction of the time.
    """

    joints: NDArray
    """The tree of joints, shape (n_joints, TABLE_WIDTH)."""
    bodies: NDArray
    """The collision bodies of the robot, shape (n_bodies, BODY_WIDTH)."""
    vertices: NDArray | None
    """Those of the robot's hulls, shape (m, 3)."""
    pairs: NDArray
    """The bodies that are tested against each other, shape (n_pairs, 2)."""
    objects: NDArray
    """Solids, shape (n_rows, BODY_WIDTH): of the world the rows from ``first`` to before ``end``, and those below ``root``."""
    points: NDArray | None
    """The vertices of their hulls, shape (m, 3), or None."""
    nodes: NDArray
    """Nodes of trees of solids (``bvh``), shape (7 n_nodes, 8)."""
    root: int
    """The root of the world's BVH; NO_NODE if there is none."""
    first: int
    """The first row of the solids that are not in the BVH: these, the unindexed ones, are tested one by one."""
    end: int
    """The row after the last of them."""
    may_touch: NDArray
    """Whether a body may touch the objects of a set, shape (n_bodies, n_sets); set 0 is of those that none may touch."""


# The types of a scene, which entries take whole. Those of robot and world are the same: kernels of two bodies are compiled once.
BOXES = Group((TABLE, TABLE, NONE, PAIRS, TABLE, NONE, MATRIX, WHOLE, WHOLE, WHOLE, TRUTH_TABLE), Scene)
SHAPES = Group((TABLE, TABLE, TABLE, PAIRS, TABLE, TABLE, MATRIX, WHOLE, WHOLE, WHOLE, TRUTH_TABLE), Scene)


class Posed(NamedTuple):
    """A row of a table of bodies, at a pose."""

    table: NDArray
    """Shape (n, BODY_WIDTH)."""
    vertices: NDArray | None
    """Vertices of the table's hulls, shape (m, 3); None if all shapes are boxes."""
    row: int
    pose: tuple
    """Twelve numbers."""


class Planes(NamedTuple):
    """Planes that have bodies on one side (``bounding_planes``)."""

    rows: NDArray
    """PLANES rows for each body, in its frame, shape (PLANES n_bodies, PLANE_WIDTH)."""
    counts: NDArray
    """How many were written for each body so far, shape (n_bodies,)."""


class Apart(NamedTuple):
    """How far bodies have to be from objects, where that is not the same for all; None where it is."""

    wider: NDArray
    """How much farther than a margin each object has to be, by its number [m], at least 0; behind them the greatest of those in
    the BVH, and the greatest of all: shape (n_objects + 2,)."""
    touching: NDArray
    """Pairs of a body and an object that may touch all the same, shape (n, PAIR_WIDTH)."""
    planes: Planes
    """Planes beside the bodies."""


class Nearness(NamedTuple):
    """The distances within which a pair is found."""

    clearance: float
    """Distance that a pair has to keep [m], which ``apart`` widens for objects."""
    apart: Apart | None
    within: float
    """Greatest distance beyond that [m]."""


class Intervals(NamedTuple):
    """Eight intervals of an edge, and what a look at them asks of every pair of bodies."""

    half: Any
    """Half of their lengths, as a fraction of the edge."""
    still: bool
    """Whether these are 0, so that nothing moves."""
    stop: bool
    """Whether a contact ends the search. Then contacts are looked for in lanes that are not clear too."""
    margin: float
    """Distance that an object has to keep [m], which ``apart`` widens."""
    apart: Apart | None
    of_world: float
    """How far rounding may put a point of an object [m]."""


class Mover(NamedTuple):
    """A body at the middles of eight intervals."""

    ball: int
    """The ball that holds it."""
    row: int
    """Its own in the table of bodies."""
    pose: Any
    """Twelve numbers."""
    center: Any
    """In the base frame [m]."""
    velocity: Any
    """Velocity of its center, the edge being passed in a unit of time [m]."""


class Reach(NamedTuple):
    """Ways of a body in eight intervals, and the distance that an object has to keep from it."""

    way: Any
    """Way of its farthest point within half of an interval, with ``slack`` [m]."""
    within: Any
    """The same where the lane is clear, else how near a contact is [m]."""
    slack: float
    """Length that rounding and the margin add [m]."""
    margin: float
    """Distance that the object has to keep [m]."""


class Carried(NamedTuple):
    """The bodies of a scene by the joint that carries them, each group within one ball, and how these move along an edge.

    The first seven fields belong to the scene, the next four to an edge (``ball_motion.write_motion``), the others to eight
    configurations on it (``ball_motion.place_balls``).
    """

    balls: NDArray
    """Joint, center in its frame [m], radius [m]: shape (n_balls, BALL_WIDTH)."""
    order: NDArray
    """The bodies, those of one ball one after the other, shape (n_bodies,)."""
    first: NDArray
    """Where those of each ball begin in ``order``, and then its length, shape (n_balls + 1,)."""
    groups: NDArray
    """The pairs of two balls: the balls, the joint that carries both, where they begin and end: shape (n_groups, GROUP_WIDTH)."""
    runs: NDArray
    """The pairs of one body of a group's first ball: the body, where they begin and end: shape (n_runs, RUN_WIDTH)."""
    others: NDArray
    """The other body of each pair, those of one run one after the other, shape (n_pairs,)."""
    steps: NDArray
    """Each joint along the edge, shape (n_joints, STEP_WIDTH)."""
    speeds: NDArray
    """The greatest speed of a point of each ball, as a joint sees it; last as the base sees it [m], (n_balls, n_joints + 1)."""
    bends: NDArray
    """The greatest acceleration of a point of each ball, as in ``speeds`` [m], shape (n_balls, n_joints + 1)."""
    slacks: NDArray
    """How far rounding, and what is allowed beside the edge, may put a point of each ball [m], shape (n_balls,)."""
    joint_rows: NDArray
    """Poses of the joints, 12 n_joints rows."""
    twist_rows: NDArray
    """Velocities of the joints' origins, and angular velocities, 6 n_joints rows."""
    ball_rows: NDArray
    """Centers of the balls, their velocities, and by how much a point of each can move, 7 n_balls rows."""
    center_rows: NDArray
    """The origins of the bodies, 3 n_bodies rows; those of a ball are written when they are first needed."""
    placed: NDArray
    """1 for each ball whose bodies' origins are written, else 0: shape (n_balls,)."""
    near: NDArray
    """The unindexed objects near a ball, shape (n_unindexed,)."""


class EdgeCheck(NamedTuple):
    """A scene, and room to decide whether edges are free in it: one per thread is enough for any number of edges."""

    scene: Scene
    carried: Carried
    work: tuple
    """Room made by ``collision.entries.continuous.interval_work``."""
    of_world: float
    """Greatest error of a point of an object by rounding [m]."""


class Edge(NamedTuple):
    """The line from q_a to q_b, and all that lies within ``spread`` of it in each entry of q, shape (n_dof,) each."""

    q_a: NDArray
    q_b: NDArray
    spread: NDArray


class Near(NamedTuple):
    """Room for the near pairs of one q, and to find them."""

    joint_rows: NDArray
    """Poses of the joints, 12 n_joints rows."""
    body_rows: NDArray
    """Poses of the bodies, 12 n_bodies rows."""
    contact_rows: NDArray
    """Shape (room + 1, CONTACT_WIDTH): the last is worked on."""
    pair_rows: NDArray
    """Shape (room, PAIR_WIDTH)."""
    last_rows: NDArray
    """The last row of each object, with any values, shape (n_objects,); without any, all solids of an object are kept."""
    stack: NDArray
    """Of the BVH."""
    heights: NDArray
    """Of what is on the stack."""
    unseen: NDArray
    """A lower bound of how much farther apart pairs are than they have to be that were not looked at, since there are many [m]:
    shape (1,), or (0,) where all are looked at."""
    planes: Planes
    """Planes beside the bodies: those written bound what is looked at later, which need not be at the same q."""
    scratch: tuple
    """Of EPA."""


class NearestPair(Record):
    """The nearest pair at one q. ``distance`` is the first field, which C reads (``native/ways.c``).

    Attributes:
        distance: The signed distance [m], infinite if there is no pair.
        body: The body of the robot, or -1.
        other: The other body, or the object, numbered from the last body on, or -1.
    """

    distance: float
    body: int
    other: int


class NearPairs(NamedTuple):
    """The pairs near each other at each q of a batch, those of one q after those of the one before, the nearest first."""

    ends: NDArray[np.int64]
    """The row after the last pair of each q, shape (n,)."""
    pairs: NDArray[np.int64]
    """``PAIR_BODY``, ``PAIR_OTHER`` and ``PAIR_OBJECT`` of each, shape (m, PAIR_WIDTH)."""
    contacts: NDArray[np.float64]
    """Shape (m, CONTACT_WIDTH)."""
    gradients: NDArray[np.float64]
    """The gradient of the distance [m/rad or 1], shape (m, n_dof); without rows unless wanted."""
