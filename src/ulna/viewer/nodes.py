"""Adds shapes, and handles that a person can drag, to the scene of a page."""

from collections.abc import Callable
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.grids import Obstacle
from ulna.description.pose import pose, quaternion_from_matrix
from ulna.description.shapes import Box, Cylinder, HalfSpace, Sphere
from ulna.viewer.palette import Color
from ulna.viewer.visuals import triangles

# Of a drag along a horizontal plane: the minimum sine of the angle between ray and plane, and the maximum distance of the new
# point from the eye, relative to the old point.
_GRAZING, _FARTHEST = 0.05, 4.0
_GROUND = (4.0, 4.0, 0.004)  # [m] the box that is drawn for a half-space


def add_shape(
    scene: viser.SceneApi,
    name: str,
    shape: Obstacle,
    color: Color,
    opacity: float | None,
    T: NDArray[np.float64] | None = None,
    **look: Any,
) -> Any:
    """Add a shape at a pose T_parent_shape, shape (4, 4). ``look``: further options of viser."""
    pose = np.eye(4) if T is None else T
    look |= {"opacity": opacity, "position": pose[:3, 3], "wxyz": quaternion_from_matrix(pose)}
    match shape:
        case Box(extents):
            return scene.add_box(name, color, extents, **look)
        case Sphere(radius):
            return scene.add_icosphere(name, radius, color, subdivisions=4, **look)
        case Cylinder(radius, length):
            return scene.add_cylinder(name, radius, length, color, **look)
        case HalfSpace():
            look["position"] = pose[:3, 3] - pose[:3, 2] * _GROUND[2] / 2
            return scene.add_box(name, color, _GROUND, **look)
        case PointCloud(points, radius):  # an opaque disc for each point
            del look["opacity"]
            single = points.astype(np.float32, copy=False)
            look |= {"point_size": radius, "point_shape": "circle", "precision": "float32"}
            return scene.add_point_cloud(name, single, color, **look)
        case _:
            return add_triangles(scene, name, triangles(shape), color, **look)


def paint(node: Any, color: Color, opacity: float | None) -> None:
    """Set the color of a shape's node, and the opacity unless the shape is a point cloud."""
    if isinstance(node, viser.PointCloudHandle):
        node.colors = np.array(color, dtype=np.uint8)
    else:
        node.color, node.opacity = color, opacity


def reshape(node: Any, old: Obstacle, new: Obstacle) -> bool:
    """Change the shape of a node in place. Returns False if that is not possible; it is for point clouds."""
    if not (isinstance(old, PointCloud) and isinstance(new, PointCloud)):
        return False
    node.points, node.point_size = new.points.astype(np.float32, copy=False), new.radius
    return True


def add_triangles(scene: viser.SceneApi, name: str, mesh: Any, color: Color, **look: Any) -> viser.MeshHandle:
    """Add a trimesh mesh in one color."""
    return scene.add_mesh_simple(name, np.asarray(mesh.vertices), np.asarray(mesh.faces), color=color, flat_shading=True, **look)


def project_to_level(eye: NDArray[Any], seen: NDArray[Any], point: NDArray[Any]) -> NDArray[Any]:
    """Project ``seen`` along the ray from the eye onto the horizontal plane through ``point``, shape (3,) each.

    Returns ``seen`` itself if the intersection is too far away.
    """
    down, way = float(point[2] - eye[2]), seen - eye
    share = down / way[2] if abs(way[2]) > _GRAZING * float(np.linalg.norm(way)) else -1.0
    return eye + share * way if 0.0 < share < _FARTHEST else seen


def offset_mesh(mesh: Any, by: float) -> Any:
    """A copy of a trimesh mesh with its vertices moved outwards [m], against flicker with the surface below.

    A vertex moves along its normal: the mean of the normals of its faces, weighted by their angles. The vertex normals of
    trimesh itself print a traceback without SciPy.
    """
    mesh, sums = mesh.copy(), np.zeros(mesh.vertices.shape)
    for corner in range(3):
        np.add.at(sums, mesh.faces[:, corner], mesh.face_angles[:, corner, None] * mesh.face_normals)
    mesh.vertices = mesh.vertices + by * sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    return mesh


class Handles:
    """A transform control: arrows and rings that a person drags.

    ``on_event`` is called in the server's thread whenever a person moves or releases it.

    Attributes:
        moved_by_hand: Whether a person has moved it since ``pop_moved`` was called.
    """

    def __init__(
        self, scene: viser.SceneApi, name: str, size: float, on_event: Callable[[], None], *, visible: bool = True
    ) -> None:
        self.control = scene.add_transform_controls(name, scale=size, line_width=3.0, depth_test=False, visible=visible)
        self._holders: set[int | None] = set()  # the browsers in which it is dragged
        self._drag_start = np.zeros(3), np.zeros(3)  # at the start of a drag of a node: the position, and the grabbed point
        self.moved_by_hand = self._released = False
        self._on_event = on_event
        self.control.on_update(self._update)

    @property
    def dragged(self) -> bool:
        """Whether it is being dragged in any browser."""
        return bool(self._holders)

    @property
    def pose(self) -> NDArray[Any]:
        """T_base_handles, shape (4, 4)."""
        return pose(self.control.position, wxyz=self.control.wxyz)

    def pop_moved(self) -> bool:
        """Whether a person has moved it since the last call."""
        moved, self.moved_by_hand = self.moved_by_hand, False
        return moved

    def pop_released(self) -> bool:
        """Whether it was released since the last call, and is dragged in no browser now."""
        let_go, self._released = self._released, False
        return let_go and not self.dragged

    def put(self, T: NDArray[Any]) -> None:
        """Move it to a pose T_base_handles, shape (4, 4), unless a person drags it or has just moved it."""
        if not self._holders and not self.moved_by_hand:
            self.control.position, self.control.wxyz = T[:3, 3], quaternion_from_matrix(T)

    def make_draggable(self, node: Any, grabbed: Callable[[], NDArray[Any] | None] = lambda: None) -> None:
        """Let a person drag a node itself: parallel to the floor, or with Shift parallel to the screen.

        Args:
            node: The node.
            grabbed: Called when a drag begins. It returns the pose to which the handles move first, shape (4, 4), or None.
        """

        async def dragged(event: viser.SceneNodeDragEvent) -> None:
            if event.phase == "start":
                T = grabbed()
                if T is not None:
                    self.control.position, self.control.wxyz = T[:3, 3], quaternion_from_matrix(T)
                self._holders.add(event.client_id)
                self._drag_start = np.array(self.control.position), np.array(event.start_position)
            else:
                eye, (position, point) = np.asarray(event.client.camera.position), self._drag_start
                to = np.array(event.end_position)
                self.control.position = position + (to if event.modifier else project_to_level(eye, to, point)) - point
                self.moved_by_hand = True
            if event.phase == "end":
                self._holders.discard(event.client_id)
                self._released = True
            self._on_event()

        node.on_drag("left")(dragged)
        node.on_drag("left", modifier="shift")(dragged)

    def show(self, *, visible: bool) -> None:
        """Show or hide it. Hiding also releases it, since the page does not send the end of that drag."""
        if not visible and self._holders:
            self._holders.clear()
            self._released = True
        self.control.visible = visible

    async def _update(self, event: viser.TransformControlsEvent) -> None:
        if event.phase == "end":  # also sent if the browser is closed during a drag
            self._holders.discard(event.client_id)
            self._released = True
        elif event.phase == "start":
            self._holders.add(event.client_id)
        else:
            self.moved_by_hand = True
        self._on_event()
