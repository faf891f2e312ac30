"""Draws where a plan ends: the robot a second time, translucent and in one colour."""

from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.pose import quaternion_from_matrix
from ulna.viewer.arm import Arm
from ulna.viewer.nodes import add_triangles
from ulna.viewer.palette import Color

_OPACITY = 0.3


class Ghost:
    """The visuals of the links that move, at another configuration. Its nodes are added when it is first shown."""

    def __init__(self, server: viser.ViserServer, arm: Arm, root: str) -> None:
        self._scene, self._arm, self._root = server.scene, arm, root
        self._nodes: dict[str, Any] = {}

    def show(self, q: NDArray[np.float64] | None, color: Color) -> None:
        """Show it at q, shape (n_dof,), in a colour; hide it if q is None."""
        robot = self._arm.robot
        if q is not None and not self._nodes:
            look = {"opacity": _OPACITY, "cast_shadow": False, "receive_shadow": False}
            for k, (link, visual) in enumerate(self._arm.visuals.items()):
                if robot.tree.link_row[link] < 0:
                    continue
                self._nodes[link] = add_triangles(self._scene, f"{self._root}/{k}", visual.to_mesh(), color, **look)
        if q is not None:
            poses = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
            for link, node in self._nodes.items():
                node.position, node.wxyz, node.color = poses[link][:3, 3], quaternion_from_matrix(poses[link]), color
        for node in self._nodes.values():
            node.visible = q is not None
