"""Makes triangles of a robot and of opaque solids as arrays: vertices, normals, colors and moving frames."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from ulna.robot import Robot
from ulna.viewer.palette import TINT, TOUCHING, Solid
from ulna.viewer.visuals import Visuals, link_visuals, triangles

CREASE = 0.75  # the cosine of the angle above which an edge is drawn sharp: 41 degrees
_CACHED_SKINS = 8  # cached skins of a robot among different shapes, one for each painting thread
_SAME_PLACE = 1e-6  # vertices within this share of a mesh's extent coincide


@dataclass(frozen=True, eq=False)
class Skin:
    """Triangles that move with frames.

    Attributes:
        points: The vertices in their frames, shape (n, 3).
        frames: The frame of each vertex, shape (n,).
        triangles: The vertices of each triangle, shape (m, 3).
        normals: The normals at the corners of the triangles, in the axes of their frames, shape (3 m, 3).
        colors: The color of each triangle as linear light, shape (m, 3).
        owners: The frame of each triangle, shape (m,).
    """

    points: NDArray[np.float64]
    frames: NDArray[np.int64]
    triangles: NDArray[np.int64]
    normals: NDArray[np.float64]
    colors: NDArray[np.float64]
    owners: NDArray[np.int64]


def linear(rgb: ArrayLike) -> NDArray[np.float64]:
    """The linear light of a color in 0..255: the inverse of ``encode`` in ``kernels.render.shading``."""
    return (np.asarray(rgb, dtype=np.float64) / 255.0) ** 2


def make_skin(scenes: Iterable[tuple[int, trimesh.Scene]]) -> Skin:
    """One skin of all scenes, each with the number of its moving frame."""
    pieces = [(frame, mesh) for frame, scene in scenes for mesh in _meshes(scene)]
    if not pieces:
        none, numbers = np.zeros((0, 3)), np.zeros(0, np.int64)
        return Skin(none, numbers, np.zeros((0, 3), np.int64), none, none, numbers)
    meshes = [mesh for _, mesh in pieces]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])[:-1]
    return Skin(
        points=np.concatenate([mesh.vertices for mesh in meshes]).astype(np.float64),
        frames=np.concatenate([np.full(len(mesh.vertices), frame) for frame, mesh in pieces]),
        triangles=np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]).astype(np.int64),
        normals=np.concatenate([corner_normals(mesh.vertices, mesh.faces) for mesh in meshes]),
        colors=np.concatenate([_colors(mesh) for mesh in meshes]),
        owners=np.concatenate([np.full(len(mesh.faces), frame) for frame, mesh in pieces]),
    )


def concatenated(a: Skin, b: Skin) -> Skin:
    """The union of two skins."""
    parts = {each.name: np.concatenate([getattr(a, each.name), getattr(b, each.name)]) for each in fields(Skin)}
    parts["triangles"] = np.concatenate([a.triangles, b.triangles + len(a.points)])
    return Skin(**parts)


def corner_normals(points: NDArray, triangles: NDArray) -> NDArray[np.float64]:
    """The normal at each corner of each triangle, shape (3 m, 3): smooth over flat edges, sharp at creases.

    1. Compute the normal of each triangle, with twice the area as its length.
    2. Group coincident corners, even if their vertices have different numbers.
    3. The normal at a corner is the sum over its group of the normals within the crease angle of its own triangle's.
    """
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    flat = np.cross(b - a, c - a)
    unit = _unit(flat)
    grid = np.round(points / max(_SAME_PLACE * float(np.ptp(points, axis=0).max()), 1e-12)).astype(np.int64)
    place = np.unique(grid, axis=0, return_inverse=True)[1].reshape(-1)[triangles].reshape(-1)
    order = np.argsort(place, kind="stable")  # the corners, sorted by groups
    counts = np.bincount(place)
    first = (np.cumsum(counts) - counts)[place[order]]
    own = order // 3
    normals = np.zeros((len(order), 3))
    for k in range(int(counts.max())):
        met = np.flatnonzero(k < counts[place[order]])
        other = own[first[met] + k]
        alike = np.einsum("ij,ij->i", unit[own[met]], unit[other]) >= CREASE
        normals[order[met[alike]]] += flat[other[alike]]
    return _unit(normals)


def _unit(vectors: NDArray) -> NDArray[np.float64]:
    """Normalized vectors. Zero vectors, from triangles without area, become (0, 0, 1)."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), (0.0, 0.0, 1.0))


def _meshes(scene: trimesh.Scene) -> Iterator[trimesh.Trimesh]:
    for mesh in scene.dump():
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            yield mesh


def _colors(mesh: trimesh.Trimesh) -> NDArray[np.float64]:
    """The color of each triangle, from its material or its own."""
    visual: Any = mesh.visual
    rgba = visual.material.main_color if hasattr(visual, "material") else visual.face_colors
    return np.broadcast_to(linear(rgba)[..., :3], (len(mesh.faces), 3))


@dataclass(frozen=True, eq=False)
class BoundingBall:
    """A ball around points.

    Attributes:
        center: The center in the base frame [m], shape (3,).
        radius: The radius [m].
        lowest: The height of the lowest point [m].
    """

    center: NDArray[np.float64]
    radius: float
    lowest: float

    @classmethod
    def of(cls, points: NDArray[np.float64]) -> "BoundingBall":
        """The ball around points in the base frame [m], shape (n, 3), centered in their AABB."""
        low, high = points.min(axis=0), points.max(axis=0)
        return cls((low + high) / 2, float(np.linalg.norm(points - (low + high) / 2, axis=1).max()), float(low[2]))


class Model:
    """The triangles of a robot, alone or together with the solids of a picture.

    Attributes:
        skin: The robot's triangles. Each moves with a link, numbered as in ``links``.
        links: The index of each link, by its name.
        missing: The meshes that could not be read, each with the reason.
    """

    def __init__(self, robot: Robot, visuals: Visuals | None = None) -> None:
        """Make the model of a robot. visuals: those of its links; read from its description unless given."""
        self.robot = robot
        self.links = {name: k for k, name in enumerate(robot.link_names)}
        visuals = link_visuals(robot) if visuals is None else visuals
        self.missing = visuals.missing
        self.skin = make_skin((self.links[link], scene) for link, scene in visuals.scenes.items())
        self._skin_among = lru_cache(_CACHED_SKINS)(self._make_skin_among)  # most pictures of a film show the same shapes

    def skin_among(self, solids: Sequence[Solid]) -> Skin:
        """The triangles of the robot and of opaque solids. The solids have the frames after those of the links."""
        return self._skin_among(tuple(solid.shape for solid in solids))

    def _make_skin_among(self, shapes: tuple[Any, ...]) -> Skin:
        if not shapes:
            return self.skin
        of_shapes = make_skin((len(self.links) + k, trimesh.Scene(triangles(shape))) for k, shape in enumerate(shapes))
        return concatenated(self.skin, of_shapes)

    def poses(self, q: NDArray[np.float64], solids: Sequence[Solid]) -> NDArray[np.float64]:
        """T_base_frame of every link at q, and of every solid, shape (n_frames, 4, 4)."""
        poses = self.robot.link_poses(q)
        return np.concatenate([poses, *((poses[self.links[solid.link]] @ solid.pose)[None] for solid in solids)])

    def paints(
        self, skin: Skin, solids: Sequence[Solid], touching: Collection[str] = ()
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The color of every triangle (linear light), shape (m, 3), and its emitted share, shape (m,).

        ``touching`` names the links that are tinted red, as on the page.
        """
        colors, glow = skin.colors.copy(), np.zeros(len(skin.colors))
        red = np.isin(skin.owners, [self.links[name] for name in touching])
        colors[red] = (1.0 - TINT) * colors[red] + TINT * linear(TOUCHING)
        for k, solid in enumerate(solids):
            own = skin.owners == len(self.links) + k
            colors[own], glow[own] = linear(solid.color), float(solid.glows)
        return colors, glow

    def points_at(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """The vertices of the robot at q, shape (n_dof,), in the base frame [m], shape (n, 3)."""
        T = self.robot.link_poses(q)[self.skin.frames]
        return np.einsum("nij,nj->ni", T[:, :3, :3], self.skin.points) + T[:, :3, 3]


def is_opaque(solid: Solid) -> bool:
    """Whether a solid is opaque."""
    return solid.opacity >= 1.0
