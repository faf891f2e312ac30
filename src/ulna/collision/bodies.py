"""Makes the tables of a robot's collision bodies and of the pairs to check, and the scene of a world.

A *scene* joins these tables with the tables of a world's objects, as compiled functions take them (``kernels.collision.scene``).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ulna.collision.allowed import AllowedCollisions
from ulna.collision.attached import Attached
from ulna.collision.objects import Objects
from ulna.collision.rounded_shapes import NO_VERTICES, hull_columns, shape_columns, tight_frame
from ulna.description.robot_description import Description, frozen
from ulna.description.shapes import ConvexMesh
from ulna.errors import GeometryError
from ulna.kernels.collision.scene import Scene
from ulna.kernels.layout import BODY_WIDTH, BOX, FRAME_WIDTH, SHAPE
from ulna.kinematics.tree import Tree

NO_PAIRS = np.zeros((0, 2), dtype=np.int64)
NO_PAIRS.setflags(write=False)  # read-only, as are the pairs of a robot: kernels are compiled for read-only arrays


@dataclass(frozen=True, eq=False)
class Bodies:
    """The collision bodies of a robot and of the objects attached to it.

    Attributes:
        names: One for each body, all different.
        links: The link that each is fixed to.
        owners: The link, or the attached object, that each is part of. Bodies of one owner are not checked against each other.
        table: The bodies as the kernels read them (``kernels.layout``), shape (n, BODY_WIDTH). A hull's frame is that of a small
            box round the hull. This keeps the boxes and balls of the kernels' first tests small.
        frames: The frames of the shapes as the description has them, shape (n, FRAME_WIDTH).
        vertices: The vertices of all hulls, shape (m, 3).
    """

    names: tuple[str, ...]
    links: tuple[str, ...]
    owners: tuple[str, ...]
    table: NDArray[np.float64]
    frames: NDArray[np.float64]
    vertices: NDArray[np.float64]

    @cached_property
    def only_boxes(self) -> bool:
        """Whether all shapes are boxes."""
        return bool((self.table[:, SHAPE] == BOX).all())

    @cached_property
    def _rows_by_owner(self) -> dict[str, list[int]]:
        """The rows of the bodies of each owner."""
        return {owner: [k for k, name in enumerate(self.owners) if name == owner] for owner in self.owners}

    def pairs_of(self, owners: Iterable[tuple[str, str]]) -> list[tuple[int, int]]:
        """All pairs of a body of a and a body of b, for each pair (a, b) of owners."""
        return [(i, j) for a, b in owners for i in self._rows_by_owner[a] for j in self._rows_by_owner[b]]

    def table_of_pairs(self, owners: Iterable[tuple[str, str]]) -> NDArray[np.int64]:
        """``pairs_of`` as an array for the kernels: read-only, shape (n, 2)."""
        pairs = np.array(self.pairs_of(owners), dtype=np.int64).reshape(-1, 2)
        pairs.setflags(write=False)
        return pairs


def make_bodies(description: Description, tree: Tree, attached: tuple[Attached, ...]) -> Bodies:
    """The collision bodies of a robot.

    Raises:
        GeometryError: It has no collision shapes and no attached objects; or it has meshes, which may be concave and so give
            wrong results.
    """
    parts = [(link.name, link.name, body.name, body.shape, body.pose) for link in description.links for body in link.collisions]
    if not parts and not attached:
        remedy = "robot.with_attached(name, shape, T, link=) gives a link one, and <collision> in a URDF does"
        raise GeometryError(
            f"robot {description.name!r} has no collision shapes, so its collisions cannot be checked: {remedy}; "
            "robot.trajectory(path) gives a path times without a collision check"
        )
    parts += [(one.link, one.name, one.name, one.shape, one.T_link_object) for one in attached]
    rows, frames, vertices = [], [], [NO_VERTICES]
    for link, _, name, shape, T in parts:
        first = sum(map(len, vertices))
        frames.append(tree.frame_row(link, T))
        if isinstance(shape, ConvexMesh):
            T_shape_box = tight_frame(shape.vertices)
            points = (shape.vertices - T_shape_box[:3, 3]) @ T_shape_box[:3, :3]
            rows.append([*tree.frame_row(link, T @ T_shape_box), *hull_columns(points, first)])
            vertices.append(points)
            continue
        try:
            rows.append([*frames[-1], *shape_columns(shape, first)])
        except GeometryError as error:
            raise GeometryError(f"link {link!r}: collision shape {name!r}: {error}") from None
    links, owners, names, *_ = zip(*parts, strict=True)
    table, points = frozen(rows, (len(rows), BODY_WIDTH)), np.concatenate(vertices)
    of_shapes = frozen(frames, (len(frames), FRAME_WIDTH))
    return Bodies(_make_distinct(names, links), links, owners, table, of_shapes, frozen(points, points.shape))


def checked_pairs(bodies: Bodies, tree: Tree, allowed: AllowedCollisions, attached: tuple[Attached, ...]) -> NDArray[np.int64]:
    """The pairs of bodies that may not touch, two indices a row.

    Pairs left out: allowed links, an attached object with its ``touch_links``, and bodies without a joint between them.
    """
    allowed_sets = {pair.links for pair in allowed}
    allowed_sets |= {frozenset((one.name, other)) for one in attached for other in one.touch_links}
    carriers = dict(zip(bodies.owners, bodies.links, strict=True))
    attached_names = {one.name for one in attached}
    checked = []
    for a, b in combinations(carriers, 2):
        rigid = tree.link_row[carriers[a]] == tree.link_row[carriers[b]] and (a in attached_names or b in attached_names)
        if not rigid and frozenset((a, b)) not in allowed_sets:
            checked.append((a, b))
    return bodies.table_of_pairs(checked)


def _make_distinct(names: tuple[str, ...], links: tuple[str, ...]) -> tuple[str, ...]:
    """The shapes' names, made different.

    A repeated name gets its link as a prefix, and a number if that is not enough.
    """
    long = [f"{link}/{name}" if names.count(name) > 1 else name for name, link in zip(names, links, strict=True)]
    return tuple(f"{name} ({long[: k + 1].count(name)})" if long.count(name) > 1 else name for k, name in enumerate(long))


def scene_of(
    joints: NDArray[np.float64],
    bodies: Bodies,
    pairs: NDArray[np.int64],
    objects: Objects,
    may_touch: NDArray[np.bool_] | None = None,
) -> Scene:
    """The scene of bodies, their pairs, and objects, for the kernels. ``may_touch`` defaults to their ``touch_table``."""
    layout = objects.layout
    vertices, points = (None, None) if bodies.only_boxes and layout.only_boxes else (bodies.vertices, layout.vertices)
    may_touch = touch_table(bodies, layout.touch_sets) if may_touch is None else may_touch
    of_world = layout.table, points, layout.nodes, layout.root, objects.first, objects.end
    return Scene(joints, bodies.table, vertices, pairs, *of_world, may_touch)


def touch_table(bodies: Bodies, touch_sets: tuple[frozenset[str], ...]) -> NDArray[np.bool_]:
    """Table of the bodies that may touch the objects of each touch set, shape (n_bodies, n_sets)."""
    may_touch = np.array([[owner in links for links in touch_sets] for owner in bodies.owners])
    may_touch.setflags(write=False)
    return may_touch
