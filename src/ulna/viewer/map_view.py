"""Shows a reachability map on a page: colored voxels, a clipping plane, and the robot inside."""

import threading
from contextlib import suppress
from typing import Self

import numpy as np
import viser

from ulna.errors import UlnaError, count_of
from ulna.ik.result import IKResult
from ulna.reachability.map import ReachabilityMap
from ulna.viewer.arm import Arm, Extent
from ulna.viewer.html import color_bar, small_text, status_line
from ulna.viewer.page import HOST, Page
from ulna.viewer.palette import GREEN, RED, UNKNOWN
from ulna.viewer.session.voxels import AXES, RAMP, Voxels
from ulna.viewer.stage import add_stage

_CLOUD, _PLANE = "/map", "/plane"
_FILL = 0.3  # half the width of a voxel's mark as a share of its edge; the gaps show the voxels behind


class MapView:
    """A running page of a map. It ends with ``stop``, or at the end of a ``with`` block.

    Attributes:
        found: The map.
        page: The page; ``page.url`` is its address.
        chosen: The index of the voxel that was clicked last; None if none was.
        result: Inverse kinematics for the orientations of that voxel.
    """

    def __init__(self, found: ReachabilityMap, *, host: str = HOST, port: int = 0) -> None:
        self.found, self.voxels = found, Voxels(found)
        self.chosen: int | None = None
        self.result: IKResult | None = None
        self._lock, self._ended = threading.RLock(), threading.Event()
        self.page = Page(host, port, title=f"{found.robot.name} - reachability - Ulna")
        with self.page.ending_if_it_fails():
            self._build(self.page.server)

    def _build(self, server: viser.ViserServer) -> None:
        self.arm = Arm(server, self.found.robot)
        self.arm.show_solids(visible=not self.arm.looks)
        self.arm.move_to(self.found.robot.home)
        ends = np.array([self.voxels.ends(axis) for axis in AXES]).T
        extent = self.arm.extent
        add_stage(self.page, Extent(np.minimum(extent.low, ends[0]), np.maximum(extent.high, ends[1])))
        self._add_panel(server.gui)
        size = _FILL * self.voxels.size
        none = np.zeros((0, 3))
        self._cloud = server.scene.add_point_cloud(
            _CLOUD, none, none.astype(np.uint8), point_size=size, point_shape="square", point_shading="flat"
        )  # flat, since shaded colors would differ from those of the color bar
        self._mark = server.scene.add_box(
            f"{_CLOUD}_mark",
            (255, 255, 255),
            (self.voxels.size, self.voxels.size, self.voxels.size),
            wireframe=True,
            visible=False,
        )
        self._handle: viser.TransformControlsHandle | None = None
        server.scene.on_click()(lambda event: self.click(np.array(event.ray_origin), np.array(event.ray_direction)))
        self._apply_axis()

    def _add_panel(self, gui: viser.GuiApi) -> None:
        summary = self.found.summary
        share = 100 * summary.reached / max(1, summary.computed)
        words = f"{summary.reached:,} of {summary.computed:,} poses reached ({share:.1f} %)"
        gui.add_html(status_line(words, GREEN if summary.reached else RED))
        if summary.computed < summary.poses:
            gui.add_html(small_text(f"{summary.poses - summary.computed:,} poses are not computed yet"))
        self.legend = gui.add_html(color_bar("Orientations reached in a voxel [%]", RAMP, ("0", "100")))
        self.axis = gui.add_dropdown("Clip across", AXES, initial_value="y", hint="The normal of the clipping plane")
        low, high = self.voxels.ends("y")
        self.plane = gui.add_slider(
            "Plane [m]",
            min=low,
            max=high,
            step=1e-3,
            initial_value=low,
            hint="Only voxels behind the plane are shown; you can also drag its arrow",
        )
        self.min_share = gui.add_slider(
            "Minimum share",
            min=0.0,
            max=1.0,
            step=0.01,
            initial_value=0.0,
            hint="Voxels with a smaller share of reached orientations are hidden",
        )
        self.status = gui.add_html(small_text("Click a voxel to see its solutions."))
        self.solution = gui.add_slider("Solution", min=1, max=2, step=1, initial_value=1, visible=False)
        self.page.add_dark_button()
        self.axis.on_update(lambda event: self._apply_axis() if event.client is not None else None)
        self.plane.on_update(lambda event: self._apply_plane() if event.client is not None else None)
        self.min_share.on_update(lambda event: self._draw() if event.client is not None else None)
        self.solution.on_update(lambda event: self._pose_arm() if event.client is not None else None)

    # ---- the shown voxels ----------------------------------------------------------------------------------------------

    @property
    def shown(self) -> np.ndarray:
        """The indices of the shown voxels."""
        return self.voxels.shown(self.axis.value, self.plane.value, self.min_share.value)

    def clip(self, axis: str, plane: float) -> None:
        """Show only the voxels behind a plane normal to an axis. plane: its coordinate [m]."""
        with self._lock:
            self.axis.value = axis  # type: ignore[assignment]
            self._apply_axis()
            self.plane.value = float(np.clip(plane, *self.voxels.ends(axis)))
            self._apply_plane()

    def click(self, origin: np.ndarray, direction: np.ndarray) -> None:
        """Choose the first shown voxel on a ray, and solve its orientations.

        origin: the start of the ray [m], shape (3,). direction: shape (3,).
        """
        with self._lock:
            chosen = self.voxels.on_ray(origin, direction, self.shown)
            if chosen is None:
                return
            self.chosen, center = chosen, self.voxels.centers[chosen]
            self._mark.position, self._mark.visible = center, True
            try:
                self.result = self.found.solutions_at(center)
            except UlnaError as error:
                self.status.content = status_line(str(error), UNKNOWN)
                return
            self._show_result(center, self.result)
            self._pose_arm()

    def _show_result(self, center: np.ndarray, result: IKResult) -> None:
        n, m = int(np.count_nonzero(result.success)), len(result.q)
        place = ", ".join(f"{x:.3f}" for x in center)
        self.status.content = status_line(f"{n} of {count_of(m, 'orientation')} reached at {place} m", GREEN if n else RED)
        self.solution.min, self.solution.max, self.solution.visible = 1, max(2, n), n > 1
        self.solution.value = 1

    def _pose_arm(self) -> None:
        with self._lock:
            solved = np.flatnonzero(self.result.success) if self.result is not None else ()
            if self.result is not None and len(solved):
                self.arm.move_to(self.result.q[solved[min(int(self.solution.value), len(solved)) - 1]])

    def _draw(self) -> None:
        with self._lock, self.page.server.atomic():
            shown = self.shown
            self._cloud.points, self._cloud.colors = self.voxels.centers[shown].astype(np.float32), self.voxels.colors[shown]

    def _apply_axis(self) -> None:
        """Put the plane behind the robot, so that no voxel hides the robot, with an arrow to drag the plane."""
        with self._lock:
            low, high = self.voxels.ends(self.axis.value)
            behind = max(low, min(float(self.arm.extent.high[AXES.index(self.axis.value)]), high - self.voxels.size))
            self.plane.min, self.plane.max, self.plane.value = low, high, behind
            if self._handle is not None:
                self._handle.remove()
            x, y, z = (name == self.axis.value for name in AXES)
            self._handle = self.page.server.scene.add_transform_controls(
                _PLANE,
                scale=0.3,
                active_axes=(x, y, z),
                disable_rotations=True,
                disable_sliders=True,
                position=self._handle_position(behind),
            )
            self._handle.on_update(lambda _: self._dragged())
        self._draw()

    def _dragged(self) -> None:
        with self._lock:
            if self._handle is not None:
                along = float(self._handle.position[AXES.index(self.axis.value)])
                self.plane.value = float(np.clip(along, self.plane.min, self.plane.max))
        self._draw()

    def _apply_plane(self) -> None:
        with self._lock:
            if self._handle is not None:
                self._handle.position = self._handle_position(self.plane.value)
        self._draw()

    def _handle_position(self, plane: float) -> np.ndarray:
        corner = np.array([self.voxels.ends(name)[1] for name in AXES])
        corner[AXES.index(self.axis.value)] = plane
        return corner

    # ---- the end -------------------------------------------------------------------------------------------------------

    @property
    def url(self) -> str:
        """The address of the page."""
        return self.page.url

    def wait(self) -> None:
        """Wait until it is stopped, or for Ctrl-C."""
        with suppress(KeyboardInterrupt):
            while not self._ended.wait(0.5):
                pass

    def stop(self) -> None:
        """Stop the page. A second call does nothing."""
        if not self._ended.is_set():
            self._ended.set()
            self.page.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
