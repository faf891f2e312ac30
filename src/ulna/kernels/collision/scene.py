"""Names the arrays of a robot, a world and their search results, as kernels and entries take them."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record
from ulna.engine.signatures import MATRIX, NONE, PAIRS, TABLE, TRUTH_TABLE, WHOLE, Group


class Scene(NamedTuple):
    """A robot and the objects of a world, in flat arrays (columns: ``kernels.layout``).

    If all shapes are boxes, ``vertices`` and ``points`` are None. Such a scene compiles without the distance search for convex
    shapes, in a fraction of the time.
    """

    joints: NDArray
    """The tree of joints, shape (n_joints, TABLE_WIDTH)."""
    bodies: NDArray
    """The collision bodies of the robot, shape (n_bodies, BODY_WIDTH)."""
    vertices: NDArray | None
    """The vertices of the robot's hulls, shape (m, 3)."""
    pairs: NDArray
    """The pairs of bodies to test against each other, shape (n_pairs, 2)."""
    objects: NDArray
    """Solids, shape (n_rows, BODY_WIDTH). The world's are the rows from ``first`` to before ``end``, and those below ``root``."""
    points: NDArray | None
    """The vertices of their hulls, shape (m, 3), or None."""
    nodes: NDArray
    """Nodes of trees of solids (``bvh``), shape (7 n_nodes, 8)."""
    root: int
    """The root of the world's BVH; NO_NODE if there is none."""
    first: int
    """The first row of the unindexed solids, which are not in the BVH and are tested one by one."""
    end: int
    """The row after the last unindexed solid."""
    may_touch: NDArray
    """Whether a body may touch the objects of a touch set, shape (n_bodies, n_sets); set 0 is empty: no body may touch them."""


# The types of a scene, which entries take whole. Robot and world have the same types: kernels of two bodies are compiled once.
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
    """Bounding planes of bodies (``bounding_planes``)."""

    rows: NDArray
    """PLANES rows for each body, in its frame, shape (PLANES n_bodies, PLANE_WIDTH)."""
    counts: NDArray
    """The number of planes written for each body, shape (n_bodies,)."""


class Margins(NamedTuple):
    """Margins of bodies from objects, where objects differ; None if one margin applies to all."""

    extra: NDArray
    """The extra margin of each object, by its number [m], at least 0; then the maximum over the BVH's objects, and over all
    objects: shape (n_objects + 2,)."""
    touching: NDArray
    """Pairs of a body and an object that may touch nevertheless, shape (n, PAIR_WIDTH)."""
    planes: Planes
    """Bounding planes of the bodies."""


class Nearness(NamedTuple):
    """The distances within which a pair is near."""

    clearance: float
    """Required distance of a pair [m]; ``margins`` widens it for objects."""
    margins: Margins | None
    within: float
    """Maximum distance beyond the required one [m]."""


class Intervals(NamedTuple):
    """Eight intervals of an edge, and the options for their test."""

    half: Any
    """Half of each length, as a fraction of the edge."""
    is_instant: bool
    """Whether the lengths are 0, so that nothing moves."""
    stop_at_contact: bool
    """Whether a contact ends the search. If so, contacts are searched in all lanes, clear or not."""
    margin: float
    """Required distance of objects [m]; ``margins`` widens it."""
    margins: Margins | None
    object_rounding: float
    """Bound on the rounding of an object's points [m]."""


class Mover(NamedTuple):
    """A body at the middles of eight intervals."""

    ball: int
    """The ball that holds it."""
    row: int
    """Its row in the table of bodies."""
    pose: Any
    """Twelve numbers."""
    center: Any
    """In the base frame [m]."""
    velocity: Any
    """Velocity of its center, if the edge takes a unit of time [m]."""


class Reach(NamedTuple):
    """Bounds on the motion of a body in eight intervals, and the required distance of an object from it."""

    motion: Any
    """Bound on the motion of its points within half of an interval, plus ``slack`` [m]."""
    within: Any
    """The same where the lane is clear; elsewhere the distance of a contact [m]."""
    slack: float
    """Length added by rounding and by the margin [m]."""
    margin: float
    """Required distance of the object [m]."""


class Carried(NamedTuple):
    """The bodies of a scene grouped into one ball per joint, and their motion along an edge.

    The first seven fields belong to the scene, the next three to an edge (``ball_motion.write_motion``), the others to eight
    configurations on it (``ball_motion.place_balls``).
    """

    balls: NDArray
    """Joint, center in its frame [m], radius [m]: shape (n_balls, BALL_WIDTH)."""
    order: NDArray
    """The bodies, grouped by ball, shape (n_bodies,)."""
    first: NDArray
    """The place in ``order`` of the first body of each ball, and then the number of bodies, shape (n_balls + 1,)."""
    groups: NDArray
    """Pairs of two balls: the balls, the joint that carries both, the first and the end run: shape (n_groups, GROUP_WIDTH)."""
    runs: NDArray
    """The pairs of one body of a group's first ball: the body, the first and the end pair: shape (n_runs, RUN_WIDTH)."""
    others: NDArray
    """The other body of each pair, grouped by run, shape (n_pairs,)."""
    steps: NDArray
    """Each joint along the edge, shape (n_joints, STEP_WIDTH)."""
    speeds: NDArray
    """Maximum speed of a ball's points, as seen from each joint, then from the base [m], shape (n_balls, n_joints + 1)."""
    bends: NDArray
    """Maximum acceleration of a ball's points, with the columns of ``speeds`` [m], shape (n_balls, n_joints + 1)."""
    slacks: NDArray
    """Bound on the displacement of a ball's points by rounding and spread [m], shape (n_balls,)."""
    joint_rows: NDArray
    """Poses of the joints, 12 n_joints rows."""
    twist_rows: NDArray
    """Velocities of the joints' origins, and angular velocities, 6 n_joints rows."""
    ball_rows: NDArray
    """Centers of the balls, their velocities, and bounds on the motion of their points, 7 n_balls rows."""
    center_rows: NDArray
    """The origins of the bodies, 3 n_bodies rows; those of a ball are written at their first use."""
    is_placed: NDArray
    """1 for each ball whose bodies' origins are written, else 0: shape (n_balls,)."""
    near: NDArray
    """The unindexed objects near a ball, shape (n_unindexed,)."""


class EdgeCheck(NamedTuple):
    """A scene with the workspace of edge checks. Each thread needs one, for any number of edges."""

    scene: Scene
    carried: Carried
    work: tuple
    """Workspace from ``collision.entries.continuous.interval_work``."""
    object_rounding: float
    """Bound on the rounding of an object's points [m]."""


class Edge(NamedTuple):
    """The line from q_a to q_b, widened by ``spread`` in each entry of q, shape (n_dof,) each."""

    q_a: NDArray
    q_b: NDArray
    spread: NDArray


class Near(NamedTuple):
    """Workspace for the near pairs of one q."""

    joint_rows: NDArray
    """Poses of the joints, 12 n_joints rows."""
    body_rows: NDArray
    """Poses of the bodies, 12 n_bodies rows."""
    contact_rows: NDArray
    """Shape (room + 1, CONTACT_WIDTH); the last row is scratch."""
    pair_rows: NDArray
    """Shape (room, PAIR_WIDTH)."""
    last_rows: NDArray
    """The last row of each object, with any values, shape (n_objects,); without entries, all solids of an object are kept."""
    stack: NDArray
    """The stack of the BVH."""
    heights: NDArray
    """Lower bounds of the distances of the nodes on the stack."""
    unseen: NDArray
    """A lower bound of the excess distance of the pairs that were skipped, since there are many [m]: shape (1,);
    or (0,) if no pair may be skipped."""
    planes: Planes
    """Bounding planes of the bodies. They stay valid for later searches, also at another q."""
    scratch: tuple
    """The workspace of EPA."""


class NearestPair(Record):
    """The nearest pair at one q. C reads the first field, ``distance`` (``native/ways.c``).

    Attributes:
        distance: The signed distance [m], infinite if there is no pair.
        body: The body of the robot, or -1.
        other: The other body, or the object, numbered from the last body on, or -1.
    """

    distance: float
    body: int
    other: int


class NearPairs(NamedTuple):
    """The pairs near each other at each q of a batch, grouped by q, the nearest first."""

    ends: NDArray[np.int64]
    """The row after the last pair of each q, shape (n,)."""
    pairs: NDArray[np.int64]
    """``PAIR_BODY``, ``PAIR_OTHER`` and ``PAIR_OBJECT`` of each pair, shape (m, PAIR_WIDTH)."""
    contacts: NDArray[np.float64]
    """Shape (m, CONTACT_WIDTH)."""
    gradients: NDArray[np.float64]
    """The gradient of the distance [m/rad or 1], shape (m, n_dof); without rows if not requested."""
