"""A pinhole camera, and its projection as arguments of the kernels."""

from dataclasses import dataclass
from math import atan, cos, sin, tan

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.errors import InputError, cited

View = str | ArrayLike | None  # where a camera is; see ``direction_to``

_CENTRINGS = 4  # iterations that center the points in the picture
_MARGIN = 1.05  # factor of the distance from which the points just fit
SIDES = {  # directions from a scene to a camera; x is forward, y left
    "corner": (0.77, -0.72, 0.36),
    "front": (1.0, 0.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "top": (1e-3, 0.0, 1.0),
}
FILM_FROM = (cos(0.75), sin(0.75), 0.42)  # the direction to a film's camera unless given
_UPRIGHT = 1e-9  # the sine of the angle between the camera's axis and z, below which "up" is not defined


@dataclass(frozen=True)
class Camera:
    """An upright camera.

    Attributes:
        position: Its position in the base frame [m].
        look_at: The point in the middle of the picture, in the base frame [m].
        fov: The vertical field of view [rad].
    """

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    fov: float = 0.6

    @classmethod
    def around(cls, middle: ArrayLike, radius: float, away: ArrayLike, aspect: float) -> "Camera":
        """A camera that sees all of a ball.

        Args:
            middle: The center of the ball in the base frame [m], shape (3,).
            radius: Its radius [m].
            away: The direction from the ball to the camera, shape (3,).
            aspect: Width by height of the picture.
        """
        half = atan(tan(cls.fov / 2.0) * min(aspect, 1.0))
        return cls._beside(np.asarray(middle), away, radius / sin(half))

    @classmethod
    def framing(cls, points: NDArray[np.float64], away: ArrayLike, aspect: float) -> "Camera":
        """A camera that shows points as large as possible and centered.

        In the axes of the camera, from the point it looks at, a point is at r (right), d (down), f (forward). Let a be the
        distance of the camera. The depth of the point is a + f. It is in the picture if |d| and |r| / aspect are at most
        tan(fov / 2) (a + f).

        Args:
            points: In the base frame [m], shape (n, 3).
            away: The direction from the points to the camera, shape (3,).
            aspect: Width by height of the picture.
        """
        middle, distance = (points.min(axis=0) + points.max(axis=0)) / 2, 1.0
        axes, slope = cls._beside(middle, away, 1.0).axes(), tan(cls.fov / 2.0)
        for _ in range(_CENTRINGS):
            r, d, f = axes @ (points - middle).T
            distance = max(distance_showing(np.array([r, d, f]), slope, aspect), 1e-3)
            seen = np.array([r, d]) / (distance + f)
            middle = middle + distance * (seen.min(axis=1) + seen.max(axis=1)) / 2 @ axes[:2]
        return cls._beside(middle, away, _MARGIN * distance)

    @classmethod
    def _beside(cls, middle: NDArray[np.float64], away: ArrayLike, distance: float) -> "Camera":
        """A camera in a direction from a point, at a distance from it [m]."""
        position = middle + np.asarray(away) / np.linalg.norm(away) * distance
        return cls(tuple(position.tolist()), tuple(middle.tolist()))

    def rays(self, width: int, height: int) -> NDArray[np.float64]:
        """The rays of the pixels, shape (4, 3).

        Row 0 is the camera's position, row 1 the direction through the raster's corner. Rows 2 and 3 are the changes of the
        direction for a pixel to the right and down.
        """
        right, down, forward = self.axes()
        sample = 2.0 * tan(self.fov / 2.0) / height
        corner = forward - right * (sample * width / 2.0) - down * (sample * height / 2.0)
        return np.array([self.position, corner, right * sample, down * sample])

    def view(self, width: int, height: int) -> NDArray[np.float64]:
        """The projection matrix, shape (3, 4).

        It maps a point in the base frame to x * depth, y * depth [pixel m] and depth [m].
        """
        right, down, forward = self.axes()
        scale = height / (2.0 * tan(self.fov / 2.0))
        rows = np.array([scale * right + width / 2.0 * forward, scale * down + height / 2.0 * forward, forward])
        return np.column_stack([rows, -rows @ np.array(self.position)])

    def place(self, point: ArrayLike, width: int, height: int) -> tuple[float, float]:
        """The position in the picture (x, y) [pixels] of a point in the base frame [m]."""
        x, y, depth = self.view(width, height) @ np.append(np.asarray(point, dtype=np.float64), 1.0)
        return float(x / depth), float(y / depth)

    def axes(self) -> NDArray[np.float64]:
        """The unit vectors right, down and forward, in the base frame, as rows: shape (3, 3)."""
        forward = np.subtract(self.look_at, self.position)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        if not np.linalg.norm(right) > _UPRIGHT:  # it looks straight down, or up
            right = np.array([0.0, -1.0, 0.0])
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(forward, right), forward])


def direction_to(camera: View, name: str = "camera") -> tuple[float, float, float]:
    """The direction from a scene to a camera.

    Args:
        camera: A name of ``SIDES``, or the angle about z, from x, and the angle above the horizon [rad], shape (2,). None is the
            direction of a film.
        name: The name of the argument, for errors.

    Raises:
        InputError: The name is unknown, or the angles are not two finite numbers.
    """
    if camera is None:
        return FILM_FROM
    if isinstance(camera, str):
        if camera not in SIDES:
            raise InputError(name, f"{cited(camera)}; {', '.join(SIDES)}, or two angles [rad] are expected")
        return SIDES[camera]
    angles = as_floats(name, camera)
    if angles.shape != (2,) or not np.isfinite(angles).all():
        raise InputError(name, f"{cited(camera)}; two finite angles [rad] are expected: about z, and above the horizon")
    turn, up = angles.tolist()
    return cos(turn) * max(cos(up), 1e-3), sin(turn) * max(cos(up), 1e-3), sin(up)


def distance_showing(points: NDArray[np.float64], slope: float, aspect: float) -> float:
    """The least distance [m] of a camera that sees points; see ``Camera.framing``.

    Args:
        points: To the right of the point that the camera looks at, down from it, and beyond it [m], shape (3, n).
        slope: tan(fov / 2).
        aspect: Width by height of the picture.
    """
    r, d, f = points
    return float((np.maximum(np.abs(d), np.abs(r) / aspect) / slope - f).max())


def sun_view(direction: ArrayLike, middle: ArrayLike, radius: float, texels: int) -> NDArray[np.float64]:
    """The projection of points to the shadow map of a sun, shape (3, 4).

    The map covers a radius around ``middle`` [m]. The third row gives the height towards the sun [m], positive within twice the
    radius of ``middle``.
    """
    towards = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    scale = texels / (2.0 * radius)
    rows = np.array([scale * right, scale * np.cross(towards, right), towards])
    return np.column_stack([rows, np.array([texels / 2.0, texels / 2.0, 2.0 * radius]) - rows @ np.asarray(middle)])
