"""Makes the triangles of a robot and of opaque solids, shared by all pictures."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from ulna.robot import Robot
from ulna.viewer.film.skin import linear, make_skin
from ulna.viewer.solid import Solid
from ulna.viewer.visuals import link_visuals, triangles


@dataclass(frozen=True, eq=False)
class BoundingBall:
    """A ball around a robot: its centre in the base frame and its radius [m]; and the height of the robot's lowest point [m]."""

    centre: NDArray[np.float64]
    radius: float
    lowest: float


class Model:
    """A robot and solids as triangles.

    Attributes:
        skin: The triangles; each moves with a link, by its index in ``link_names``, or with a solid, numbered after the links.
        missing: The meshes that could not be read, each with the reason.
    """

    def __init__(self, robot: Robot, solids: Sequence[Solid] = ()) -> None:
        self.robot = robot
        frames = {name: k for k, name in enumerate(robot.link_names)}
        visuals = link_visuals(robot)
        self.missing = visuals.missing
        scenes = [(frames[link], scene) for link, scene in visuals.scenes.items()]
        self._solids = {solid.name: len(frames) + k for k, solid in enumerate(solids) if is_opaque(solid)}
        scenes += [(self._solids[solid.name], trimesh.Scene(triangles(solid.shape))) for solid in solids if is_opaque(solid)]
        self.skin = make_skin(scenes)
        self.links = frames
        self.n_frames = len(frames) + len(solids)

    def poses(self, q: NDArray[np.float64], solids: Sequence[Solid]) -> NDArray[np.float64]:
        """T_base_frame of every link at q and of every solid, shape (n_frames, 4, 4)."""
        poses = np.tile(np.eye(4), (self.n_frames, 1, 1))
        poses[: len(self.links)] = self.robot.link_poses(q)
        for solid in solids:
            if is_opaque(solid):
                poses[self._solids[solid.name]] = poses[self.links[solid.link]] @ solid.pose
        return poses

    def paints(self, solids: Sequence[Solid]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The colour of every triangle (linear light), shape (m, 3), and the part of it that it emits, shape (m,)."""
        colors, glow = self.skin.colors.copy(), np.zeros(len(self.skin.colors))
        for solid in solids:
            if is_opaque(solid):
                own = self.skin.owners == self._solids[solid.name]
                colors[own], glow[own] = linear(solid.color), float(solid.glows)
        return colors, glow

    def bounding_ball(self, q: NDArray[np.float64]) -> BoundingBall:
        """A ball around the robot at q, shape (n_dof,)."""
        poses, skin = self.robot.link_poses(q), self.skin
        own = skin.frames < len(poses)
        T, p = poses[skin.frames[own]], skin.points[own]
        placed = np.einsum("nij,nj->ni", T[:, :3, :3], p) + T[:, :3, 3]
        low, centre = placed.min(axis=0), (placed.min(axis=0) + placed.max(axis=0)) / 2
        return BoundingBall(centre, float(np.linalg.norm(placed - centre, axis=1).max()), float(low[2]))


def is_opaque(solid: Solid) -> bool:
    """Whether a solid hides what is behind it."""
    return solid.opacity >= 1.0
