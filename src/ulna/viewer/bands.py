"""Draws what a motion keeps: the bar about a line, and the cones in which an axis stays."""

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.pose import quaternion_from_matrix
from ulna.ik.task import Task
from ulna.viewer.palette import TRAIL, Color
from ulna.viewer.session.planned_motion import ASIDE, TILT

_OPACITY = 0.35
_CORNERS = 32  # of a cone


class Bands:
    """The bar and the cones, hidden at first. size: the robot's [m]."""

    def __init__(self, scene: viser.SceneApi, size: float) -> None:
        look = {"opacity": _OPACITY, "visible": False, "cast_shadow": False, "receive_shadow": False}
        side = np.sqrt(2.0) * ASIDE  # a square whose corners are as far away as is allowed
        self.bar = scene.add_box("/plan/bar", TRAIL, (side, side, 1.0), **look)
        angle, height = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False), 0.3 * size
        rim = height * np.stack([np.cos(angle) * np.tan(TILT), np.sin(angle) * np.tan(TILT), np.ones(_CORNERS)], axis=1)
        vertices = np.concatenate([rim, -rim, np.zeros((1, 3))])  # below the hand, where the arm does not hide it, and above
        k = np.arange(_CORNERS)
        upper = np.stack([np.full(_CORNERS, 2 * _CORNERS), k, (k + 1) % _CORNERS], axis=1)
        faces = np.concatenate([upper, upper + np.array([0, _CORNERS, _CORNERS])])
        self.cone = scene.add_mesh_simple("/plan/cone", vertices, faces, color=TRAIL, side="double", **look)

    def show_line(self, ends: NDArray[np.float64] | None, color: Color) -> None:
        """Show the bar about the line between two points [m], shape (2, 3), in a colour; hide it for None."""
        self.bar.visible = ends is not None
        if ends is not None:
            along = ends[1] - ends[0]
            length = float(np.linalg.norm(along))
            side = self.bar.dimensions[0]
            self.bar.dimensions, self.bar.color = (side, side, length), color
            self.bar.position = ends.mean(axis=0)
            self.bar.wxyz = quaternion_from_matrix(Task.pointing(along / length).frame)

    def show_tilt(self, point: NDArray[np.float64] | None) -> None:
        """Show the cones above and below a point [m], shape (3,); hide it for None."""
        self.cone.visible = point is not None
        if point is not None:
            self.cone.position = point
