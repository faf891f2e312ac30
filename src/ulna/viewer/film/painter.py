"""Paints pictures of a robot, solids and translucent collision shapes on the CPU, without a display."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ulna.description.shapes import Box, Capsule, Cylinder, Sphere
from ulna.kernels.render.render_layout import NOTHING
from ulna.viewer.film.camera import Camera, sun_view
from ulna.viewer.film.entries import rendering
from ulna.viewer.film.skin import Model, Skin, is_opaque, linear
from ulna.viewer.palette import INK, TO_SUN, Solid

# The sides of a cube of edge 2, each as four corners in order around the side.
_SIDES = np.array(
    [
        np.roll([(sign, y * sign, z) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis, axis=1)
        for axis in range(3)
        for sign in (-1, 1)
    ],
    dtype=np.float64,
)
_SECTORS = 16  # of a shape of revolution
_STEPS = np.linspace(-0.5, 0.5, 5) * np.pi  # latitudes of a sphere's facets [rad]
_SHADE = 0.25  # a side that faces down is darker by this share
TEXELS = 1024  # along a side of the sun's shadow map
_LETTERS = 0.03  # the height of the letters, relative to the picture
_MIN_LETTERS = 11  # [pixels] the minimum height of readable letters
_PAPER = (255, 255, 255, 215)
NO_LAMP = (0.0, 0.0, -1.0, -1.0, -1.0)


Array = NDArray[np.float64]


def facets_of(shape: Box | Capsule | Cylinder | Sphere) -> Array:
    """The sides of a shape about its origin, each as four corners in order [m], shape (n, 4, 3)."""
    if isinstance(shape, Box):
        return _SIDES * shape.half_extents
    middle = 0.0 if isinstance(shape, Sphere) else shape.length / 2
    if isinstance(shape, Cylinder):
        outline = np.array([(0.0, -middle), (shape.radius, -middle), (shape.radius, middle), (0.0, middle)])
    else:  # half a sphere at each end
        arc = shape.radius * np.column_stack([np.cos(_STEPS), np.sin(_STEPS)])
        outline = np.concatenate([arc[:3] - [0.0, middle], arc[2 if middle else 3 :] + np.array([0.0, middle])])
    turn = np.linspace(0.0, 2 * np.pi, _SECTORS + 1)
    r, z = np.broadcast_to(outline[:, None, :], (len(outline), len(turn), 2)).transpose(2, 0, 1)
    points = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1)
    return np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 3)


def make_panes(solids: Sequence[tuple[Solid, Array]], eye: Array) -> tuple[Array, Array]:
    """The sides of translucent shapes that face the eye, sorted from far to near.

    Args:
        solids: The shapes, each with its T_base_solid, shape (4, 4).
        eye: The position of the eye in the base frame [m], shape (3,).

    Returns:
        The corners of the sides in the base frame [m], shape (4 n, 3), four in order around each side; and their red, green,
        blue (linear light) and opacity, shape (n, 4).
    """
    quads, paints = [np.empty((0, 4, 3))], [np.empty((0, 4))]
    for solid, T in solids:
        corners = facets_of(solid.shape) @ T[:3, :3].T + T[:3, 3]
        outwards = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        outwards *= np.sign(np.einsum("ij,ij->i", outwards, corners.mean(axis=1) - T[:3, 3]))[:, None]
        seen = np.einsum("ij,ij->i", outwards, eye - corners.mean(axis=1)) > 0.0
        upwards = outwards[:, 2] / np.maximum(np.linalg.norm(outwards, axis=1), 1e-12)
        light = linear(solid.color) * (1.0 - _SHADE * (0.5 - 0.5 * upwards[:, None]))
        quads.append(corners[seen])
        paints.append(np.column_stack([light, np.full(len(corners), solid.opacity)])[seen])
    sides, colors = np.concatenate(quads), np.concatenate(paints)
    order = np.argsort(-np.linalg.norm(sides.mean(axis=1) - eye, axis=1), kind="stable")
    return sides[order].reshape(-1, 3), colors[order]


@dataclass(frozen=True)
class Caption:
    """Text in a picture.

    Attributes:
        text: The text; nothing is written if it is empty.
        position: The middle of the upper edge of the text, in the base frame [m].
    """

    text: str
    position: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Picture:
    """The contents of a picture.

    Attributes:
        q: Joint positions of the robot [rad or m], shape (n_dof,).
        camera: The camera.
        solids: Shapes in the scene, each on a link.
        caption: Text that is written over the picture.
        touching: The links that are shown in red.
    """

    q: NDArray[np.float64]
    camera: Camera
    solids: tuple[Solid, ...] = ()
    caption: Caption | None = None
    touching: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Ground:
    """The floor under the robot.

    Attributes:
        middle: The middle of everything shown, in the base frame [m].
        radius: The radius of a ball around ``middle`` that contains everything shown [m].
        height: The height of the floor [m].
        cell: The side of a cell of the floor's grid [m].
    """

    middle: tuple[float, float, float]
    radius: float
    height: float = 0.0
    cell: float = 0.1


class Painter:
    """Paints one picture at a time on its own raster. Several painters may work at once.

    Args:
        model: The robot.
        size: Width and height of the pictures [pixels].
        ground: The floor.
        samples: The number of samples per pixel, across and down.
    """

    def __init__(self, model: Model, size: tuple[int, int], ground: Ground, samples: int = 2) -> None:
        self.model, self.ground, self.samples = model, ground, samples
        self.width, self.height = size
        raster = (self.height * samples, self.width * samples)
        self._nearness, self._numbers = np.empty(raster, np.float32), np.empty(raster, np.int32)
        self._shadows = np.empty((TEXELS, TEXELS), np.float32)
        self._seen = self._lit = np.empty((0, 3))
        self._light = np.empty((self.height, self.width, 3), np.float32)
        self._sun = sun_view(TO_SUN, ground.middle, ground.radius, TEXELS)

    def paint(self, picture: Picture) -> NDArray[np.uint8]:
        """Paint the pixels of a picture: red, green, blue, shape (height, width, 3).

        1. Draw the shadow map: the heights that the sun sees.
        2. Find the triangle that the camera sees at each sample.
        3. Compute the light of each pixel.
        4. Blend the translucent boxes over it.
        5. Write the caption.
        """
        solids = [solid for solid in picture.solids if is_opaque(solid)]
        skin, poses = self.model.skin_among(solids), self.model.poses(picture.q, solids)
        colors, glow = self.model.paints(skin, solids, picture.touching)
        view = picture.camera.view(self._numbers.shape[1], self._numbers.shape[0])
        self._draw(skin, poses, view, glow)
        self._shade(picture, skin, poses, colors, glow)
        self._lay_panes(picture, poses, view)
        pixels = np.empty((self.height, self.width, 3), np.uint8)
        rendering.encode(self._light, pixels)
        if picture.caption is not None:
            place = picture.camera.place(picture.caption.position, self.width, self.height)
            write_text(pixels, picture.caption.text, place)
        return pixels

    def _draw(self, skin: Skin, poses: NDArray, view: NDArray, glow: NDArray) -> None:
        """Draw the shadow map of the sun, and the triangles that the camera sees."""
        if len(self._seen) != len(skin.points):
            self._seen, self._lit = np.empty_like(skin.points), np.empty_like(skin.points)
        frames = _twelves(poses)
        rendering.place_points(skin.points, skin.frames, frames, _map(self._sun, 0.0), self._lit)
        rendering.place_points(skin.points, skin.frames, frames, _map(view, 1.0), self._seen)
        self._shadows.fill(0.0)
        self._nearness.fill(0.0)
        self._numbers.fill(NOTHING)
        rendering.draw_triangles(self._lit, skin.triangles[glow == 0.0], self._shadows, None)
        rendering.draw_triangles(self._seen, skin.triangles, self._nearness, self._numbers)

    def _shade(self, picture: Picture, skin: Skin, poses: NDArray, colors: NDArray, glow: NDArray) -> None:
        rows = self._numbers.shape
        rendering.shade_pixels(
            rendering.Raster(self._seen, skin.triangles, self._numbers, self._nearness),
            (skin.normals, colors, glow, skin.owners),
            np.ascontiguousarray(poses[:, :3, :3]),
            picture.camera.rays(rows[1], rows[0]),
            rendering.Lighting(
                self._sun, self._shadows, np.array([self.ground.height, self.ground.cell, *self._lamp(picture, poses)])
            ),
            self._light,
        )

    def _lamp(self, picture: Picture, poses: NDArray) -> tuple[float, ...]:
        """The position of the lamp on the floor and its light, as ``kernels.render.illumination`` takes them."""
        for solid in picture.solids:
            if solid.glows:
                x, y = (poses[self.model.links[solid.link]] @ solid.pose)[:2, 3]
                return (x, y, *linear(solid.color))
        return NO_LAMP

    def _lay_panes(self, picture: Picture, poses: NDArray, view: NDArray) -> None:
        boxes = [(solid, poses[self.model.links[solid.link]] @ solid.pose) for solid in picture.solids if not is_opaque(solid)]
        points, paints = make_panes(boxes, np.array(picture.camera.position))
        placed = np.empty_like(points)
        still = np.zeros(len(placed), np.int64)
        rendering.place_points(points, still, _twelves(np.eye(4)[None]), _map(view, 1.0), placed)
        rendering.lay_panes(placed, paints, self._nearness, self._light)


def _twelves(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poses, shape (n, 4, 4), as rows of twelve numbers, shape (n, 12), which kernels take."""
    return np.ascontiguousarray(poses[:, :3]).reshape(-1, 12)


def _map(view: NDArray[np.float64], has_depth: float) -> NDArray[np.float64]:
    """A projection as ``place_points`` takes it, shape (1, 13)."""
    return np.append(view.ravel(), has_depth)[None]


def write_text(pixels: NDArray[np.uint8], text: str, place: tuple[float, float]) -> None:
    """Write text on a light strip into pixels, shape (height, width, 3).

    place: the middle of the upper edge of the strip (x, y) [pixels].
    """
    if not text:
        return
    height, width = pixels.shape[:2]
    font = _font(max(round(_LETTERS * height), _MIN_LETTERS))
    left, _, right, _ = font.getbbox(text)
    _, top, _, bottom = font.getbbox("Ag")  # the height of all letters
    margin = 0.4 * (bottom - top)
    wide, high = right - left + 2 * margin, bottom - top + 1.6 * margin
    x = min(max(place[0] - wide / 2, margin), width - wide - margin)
    y = min(max(place[1], margin), height - high - margin)
    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image, "RGBA")
    draw.rounded_rectangle((x, y, x + wide, y + high), radius=margin, fill=_PAPER)
    draw.text((x + margin - left, y + 0.8 * margin - top), text, font=font, fill=INK)
    pixels[:] = np.asarray(image)


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font of Pillow, so that no system font is needed."""
    return ImageFont.load_default(size)
