"""Draws the demo: the arm, its boxes, the movable box with its handles, the light with its word."""

import numpy as np
import viser
from numpy.typing import NDArray
from trimesh.exchange.gltf import export_glb

from ulna.collision.report import Report
from ulna.demo import BOX, BOX_NAME, LIGHT, LIGHT_POSITION, Demo, light_color
from ulna.model.pose import pose, quaternion_from_matrix
from ulna.picture import MOVABLE, WORD_POSITION, arm_boxes
from ulna.robot import Robot
from ulna.viewer.body import link_meshes


class DemoScene:
    """The scene's handles. ``draw_arm`` and ``draw_report`` are all that changes from frame to frame."""

    def __init__(self, server: viser.ViserServer, demo: Demo) -> None:
        self.demo = demo
        self.server = server
        scene = server.scene
        scene.set_up_direction("+z")
        scene.add_grid("/floor", width=2.4, height=2.4, cell_size=0.1, section_size=0.6, cell_color=(225, 228, 232))
        server.initial_camera.position = (1.75, -1.45, 1.0)
        server.initial_camera.look_at = (0.2, 0.0, 0.36)
        server.initial_camera.fov = 0.7
        self.links = _add_links(scene, demo.robot)
        self.boxes = _add_boxes(scene, demo.robot)
        untouched = Report(())
        color = light_color(untouched)
        self.light = scene.add_cylinder("/light", LIGHT.radius, LIGHT.length, color, position=LIGHT_POSITION)
        self.word = scene.add_label(
            "/light/word", str(untouched), position=WORD_POSITION, anchor="top-center", font_screen_scale=1.3
        )
        start = demo.world.pose(BOX_NAME)
        self.handles = scene.add_transform_controls(
            "/movable", scale=0.22, line_width=3.0, depth_test=False, position=start[:3, 3], wxyz=quaternion_from_matrix(start)
        )
        scene.add_box("/movable/box", MOVABLE, BOX.extents)
        self._touching: tuple[str, ...] = ()

    def handle_pose(self) -> NDArray[np.float64]:
        """T_base_box as the handles stand."""
        return pose(self.handles.position, wxyz=self.handles.wxyz)

    def put_handles(self, T: NDArray[np.float64]) -> None:
        """Move the handles, and the box with them."""
        self.handles.position, self.handles.wxyz = T[:3, 3], quaternion_from_matrix(T)

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Put every link where it stands at q."""
        poses = self.demo.robot.link_poses(q)
        turns = quaternion_from_matrix(poses)
        for k, link in self.links.items():
            link.position, link.wxyz = poses[k, :3, 3], turns[k]

    def draw_report(self, report: Report) -> None:
        """Colour the light, its word and the boxes that touch."""
        if report.touching == self._touching:
            return
        self.light.color = light_color(report)
        self.word.text = str(report)
        for solid in arm_boxes(self.demo.robot, report.touching):
            if (solid.name in self._touching) != (solid.name in report.touching):
                self.boxes[solid.name].color, self.boxes[solid.name].opacity = solid.color, solid.opacity
        self._touching = report.touching

    def show_boxes(self, visible: bool) -> None:  # noqa: FBT001 - viser calls it so
        """Show or hide the arm's twelve boxes."""
        for box in self.boxes.values():
            box.visible = visible


def _add_links(scene: viser.SceneApi, robot: Robot) -> dict[int, viser.FrameHandle]:
    """A frame for each link that shows anything or carries a box, by its place in ``link_names``."""
    meshes = link_meshes(robot)
    carriers = {link.name for link in robot.description.links if link.collisions}
    frames = {}
    for k, name in enumerate(robot.link_names):
        if name in meshes or name in carriers:
            frames[k] = scene.add_frame(f"/arm/{name}", show_axes=False)
        if name in meshes:
            scene.add_glb(f"/arm/{name}/body", export_glb(meshes[name]))
    return frames


def _add_boxes(scene: viser.SceneApi, robot: Robot) -> dict[str, viser.BoxHandle]:
    return {
        solid.name: scene.add_box(
            f"/arm/{solid.link}/{solid.name}",
            solid.color,
            solid.shape.extents,
            position=solid.pose[:3, 3],
            wxyz=quaternion_from_matrix(solid.pose),
            opacity=solid.opacity,
            cast_shadow=False,
            receive_shadow=False,
        )
        for solid in arm_boxes(robot)
    }
