"""Places the light, the floor and the camera of a page, and adds the floor as an obstacle."""

import io
from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np
import viser
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import ConvexMesh, HalfSpace, Mesh, Primitive, UnknownShape
from ulna.robot import Robot
from ulna.viewer.arm import Extent
from ulna.viewer.film.camera import SIDES, Camera, distance_showing
from ulna.viewer.page import Page
from ulna.viewer.palette import FLOOR_CELLS, FLOOR_SECTIONS, SKY, TO_SUN
from ulna.viewer.visuals import outlines_near, triangles

_SUN, _SKY = 3.4, 1.5  # intensities
_SPOT, _SHADED = 6.0, 3.0  # [radii of the robot] the distance of the spotlight that casts shadows, and its lit radius
_SPOT_SHARE = 0.65  # the share of the sun's light that casts shadows
_NEARBY = 4.0  # [radii of the robot] obstacles farther away neither lower the floor nor move the camera
_MAX_VIEW = 2.5  # [radii of the robot] the largest scene for which the camera moves back
_SHADOW = 0.4  # opacity of the shadows on the floor
_STEPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # [m] possible sides of the floor's cells
_PICTURE_S = 60.0  # the maximum time that a browser takes for a picture
_FIELD_OF_VIEW = 0.7  # [rad] from the bottom to the top of the page
_ROOM = 1.15  # radii of the robot that the camera shows at least, for new obstacles beside it
_ASPECT = 1.1  # width by height of the narrowest window in which the scene fits at this distance


def add_light(scene: viser.SceneApi, center: ArrayLike, radius: float) -> None:
    """Add the light of the sky, and of a sun in the same direction as in a film.

    Two features of viser are slow on a computer without a GPU, and are not used. Reflections of an environment take fifteen
    seconds before the first picture. A directional light draws its shadows from three cameras, and a picture takes three times as
    long as with one spotlight. So a part of the sun is a directional light without shadows, which is everywhere. The other part
    is a spotlight with shadows around the robot, which ``head.html`` sharpens. viser's tone mapping cannot be changed.

    Args:
        scene: The scene to which the light is added.
        center: The middle of the robot [m], shape (3,).
        radius: Half the diagonal of the robot [m].
    """
    to_sun = np.array(TO_SUN) / np.linalg.norm(TO_SUN)
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(198, 204, 214), intensity=_SKY)
    scene.add_light_directional("/light/sun", intensity=(1.0 - _SPOT_SHARE) * _SUN, cast_shadow=False, position=tuple(to_sun))
    scene.add_light_spot(
        "/light/shadows",
        intensity=_SPOT_SHARE * _SUN,
        decay=0.0,  # equally bright at any distance, like the sun
        angle=float(np.arctan(_SHADED / _SPOT)),
        penumbra=1.0,
        cast_shadow=True,
        position=tuple(np.asarray(center) + _SPOT * radius * to_sun),
        direction=tuple(-to_sun),
    )


def add_floor(page: Page, height: float, cell: float, fade: float) -> viser.GridHandle:
    """Add the lines of the floor. All arguments are in meters.

    height: of the floor. cell: the side of its cells. fade: the distance from the camera at which the lines fade out.
    """
    floor = page.floor = page.server.scene.add_grid(
        "/floor",
        infinite_grid=True,
        fade_distance=fade,
        fade_strength=1.6,
        cell_size=cell,
        section_size=6 * cell,
        cell_thickness=0.5,
        section_thickness=0.9,
        cell_color=FLOOR_CELLS,
        section_color=FLOOR_SECTIONS,
        shadow_opacity=_SHADOW,
        position=(0.0, 0.0, height),
    )
    return floor


def add_stage(page: Page, extent: Extent, scene: Extent | None = None) -> viser.GridHandle:
    """Add the light and the floor, and place the camera so that it sees the scene.

    Args:
        page: The page.
        extent: The robot's AABB. The light, the floor and its cells have its size.
        scene: The AABB of the robot and its obstacles; the robot's if not given.

    Returns:
        The floor, under the robot's lowest point.
    """
    server, scene = page.server, scene or extent
    radius = extent.radius
    cell = next((step for step in _STEPS if step > radius / 10), _STEPS[-1])
    server.scene.set_up_direction("+z")
    add_light(server.scene, extent.center, radius)
    away = np.array(SIDES["corner"])
    distance = distance_to(scene, extent, away)
    floor = add_floor(page, min(float(extent.low[2]), 0.0) - max(1e-3, 4e-3 * radius), cell, 4.0 * distance)
    server.initial_camera.fov = _FIELD_OF_VIEW
    server.initial_camera.look_at = tuple(scene.center)
    server.initial_camera.position = tuple(scene.center + distance * away / np.linalg.norm(away))
    server.initial_camera.far = max(100.0, 20 * distance)
    stand_back_where_narrow(server, _ASPECT)
    return floor


def distance_to(scene: Extent, robot: Extent, direction: ArrayLike) -> float:
    """The distance [m] at which a camera in a direction from a scene's center sees all corners of its AABB.

    It also sees the robot with room for new obstacles beside it.
    """
    corners = np.stack(np.meshgrid(*zip(scene.low, scene.high, strict=True)), axis=-1).reshape(8, 3) - scene.center
    x, y, z = np.asarray(direction, dtype=np.float64).tolist()
    seen = Camera((x, y, z), (0.0, 0.0, 0.0)).axes() @ corners.T
    to_corners = distance_showing(seen, np.tan(_FIELD_OF_VIEW / 2), _ASPECT)
    return max(to_corners, float(_ROOM * robot.radius / np.sin(_FIELD_OF_VIEW / 2)))


def scene_extent(world: World, extent: Extent) -> Extent:
    """The AABB of a robot and the obstacles near it; that of the robot alone if theirs is much larger."""
    points = np.concatenate([np.stack([extent.low, extent.high]), *_solids_near(world, extent)])
    scene = Extent(points.min(axis=0), points.max(axis=0))
    return scene if scene.radius <= _MAX_VIEW * extent.radius else extent


class SightPanel:
    """Buttons that set the direction of view, switch to dark colors, and save a picture.

    Args:
        page: The page.
        robot: The robot's AABB.
        scene: Returns the AABB that the camera has to see.
    """

    def __init__(self, page: Page, robot: Extent, scene: Callable[[], Extent]) -> None:
        self._robot, self._scene, server = robot, scene, page.server
        self.sides = server.gui.add_button_group("See from", tuple(SIDES))
        page.add_dark_button()
        self.picture = server.gui.add_button("Save picture", hint="Download the scene, as this browser shows it, as a .png file")
        self.sides.on_click(self._turn)
        self.picture.on_click(self._save)

    def _save(self, event: viser.GuiEvent) -> None:
        """Send a browser the picture of its canvas, which is transparent, on a light sky."""
        if (client := event.client) is None:
            return
        height, width = client.camera.image_height, client.camera.image_width
        seen = client.get_render(height, width, transport_format="png", timeout=_PICTURE_S)
        levels = np.linspace(*SKY, height)[:, None, :]
        share = seen[..., 3:] / 255.0
        picture = (share * seen[..., :3] + (1.0 - share) * levels).round().astype(np.uint8)
        content = io.BytesIO()
        Image.fromarray(picture).save(content, "png")
        client.send_file_download("ulna.png", content.getvalue(), save_immediately=True)

    def _turn(self, event: viser.GuiEvent) -> None:
        """Move the camera of the tab in which the button was clicked, so that it sees the whole scene."""
        if event.client is None:
            return
        scene, camera, direction = self._scene(), event.client.camera, np.array(SIDES[event.target.value])
        distance = distance_to(scene, self._robot, direction) * max(1.0, _ASPECT / max(camera.aspect, 0.1))
        with event.client.atomic():
            camera.position = scene.center + distance * direction / np.linalg.norm(direction)
            camera.look_at = scene.center


def stand_back_where_narrow(server: viser.ViserServer, aspect: float) -> None:
    """Move the camera of each new browser back if its window is narrower than ``aspect``, so that the scene fits.

    aspect: width by height.
    """

    def stand_back(client: viser.ClientHandle) -> None:
        factor = aspect / max(client.camera.aspect, 0.1)
        if factor > 1.0:
            start, middle = server.initial_camera.position, server.initial_camera.look_at
            with client.atomic():
                client.camera.position = middle + factor * (start - middle)
                client.camera.look_at = middle  # viser moves it with the position

    server.on_client_connect(stand_back)


NAME = "floor"
_BELOW = 1e-3  # [m] the distance of the floor below the lowest point of the fixed links, which must not touch it


class Floor:
    """A checkbox that adds the floor as an obstacle. ``changing``: the context of that change."""

    def __init__(
        self, gui: viser.GuiApi, world: World, height: float, changing: Callable[[], AbstractContextManager[None]]
    ) -> None:
        self._world, self._height, self._changing = world, height, changing
        self.on = gui.add_checkbox(
            "Floor", initial_value=NAME in world.names, hint=f"An obstacle: everything below z = {height:.3f} m"
        )
        self.on.on_update(self._set)

    def show(self) -> None:
        """Set the checkbox, since the floor may have been deleted like any obstacle."""
        self.on.value = NAME in self._world.names

    async def _set(self, event: viser.GuiEvent) -> None:
        if event.client is None:
            return
        with self._changing():
            if self.on.value and NAME not in self._world.names:
                self._world.add(NAME, HalfSpace(), pose((0.0, 0.0, self._height)))
            elif not self.on.value and NAME in self._world.names:
                self._world.remove(NAME)


def height_under(world: World, extent: Extent) -> float:
    """The height of a floor under the obstacles near a robot [m], so that it cuts none of them."""
    lowest = min([0.0, *(float(points[:, 2].min()) for points in _solids_near(world, extent))])
    return lowest - max(1e-3, 4e-3 * extent.radius)


def _solids_near(world: World, extent: Extent) -> list[NDArray[np.float64]]:
    return outlines_near(world, extent.center, _NEARBY * extent.radius, Primitive | ConvexMesh)


def floor_height(robot: Robot, drawn: float) -> float:
    """The height of a floor that the fixed links do not touch, at most ``drawn`` [m].

    drawn: the height of the drawn floor.
    """
    places = dict(zip(robot.link_names, robot.link_poses(robot.home), strict=True))
    lowest = [drawn]
    for link in robot.description.links:
        for body in link.collisions if robot.tree.link_row[link.name] < 0 else ():
            if not isinstance(body.shape, Mesh | HalfSpace | UnknownShape):
                T = places[link.name] @ body.pose
                lowest.append(float((triangles(body.shape).vertices @ T[2, :3] + T[2, 3]).min()) - _BELOW)
    return float(np.min(lowest))
