"""A pinhole camera, and its projection in the form of the kernels' arguments."""

from dataclasses import dataclass
from math import atan, cos, sin, tan

import numpy as np
from numpy.typing import ArrayLike, NDArray

_CENTRINGS = 4  # times that a camera is turned to the middle of what it sees
_MARGIN = 1.05  # of the distance from which a camera frames points
_UPRIGHT = 1e-9  # the sine of the angle between its axis and z, below which "up" is not defined


@dataclass(frozen=True)
class Camera:
    """An upright camera.

    Attributes:
        position: Its position in the base frame [m].
        look_at: The point in the middle of the picture [m].
        fov: The vertical field of view [rad].
    """

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    fov: float = 0.6

    @classmethod
    def around(cls, middle: ArrayLike, radius: float, turn: float, aspect: float) -> "Camera":
        """A camera that sees all of a ball from above.

        Args:
            middle: The center of the ball in the base frame [m], shape (3,).
            radius: Its radius [m].
            turn: The angle of the camera about z, from x [rad].
            aspect: Width by height of the picture.
        """
        half = atan(tan(cls.fov / 2.0) * min(aspect, 1.0))
        return cls._from_above(np.asarray(middle), turn, radius / sin(half))

    @classmethod
    def framing(cls, points: NDArray[np.float64], turn: float, aspect: float) -> "Camera":
        """A camera that sees points from above, as large as there is room for, and in the middle of the picture.

        From the point that the camera looks at, a point is r to the right, d down and f forward. At a distance a of the camera
        its depth is a + f, and it is in the picture if d and r / aspect are at most tan(fov / 2) (a + f) long.

        Args:
            points: In the base frame [m], shape (n, 3).
            turn: The angle of the camera about z, from x [rad].
            aspect: Width by height of the picture.
        """
        middle, distance = (points.min(axis=0) + points.max(axis=0)) / 2, 1.0
        axes, slope = cls._from_above(middle, turn, 1.0).axes(), tan(cls.fov / 2.0)
        for _ in range(_CENTRINGS):
            r, d, f = axes @ (points - middle).T
            distance = max(float((np.maximum(np.abs(d), np.abs(r) / aspect) / slope - f).max()), 1e-3)
            seen = np.array([r, d]) / (distance + f)
            middle = middle + distance * (seen.min(axis=1) + seen.max(axis=1)) / 2 @ axes[:2]
        return cls._from_above(middle, turn, _MARGIN * distance)

    @classmethod
    def _from_above(cls, middle: NDArray[np.float64], turn: float, distance: float) -> "Camera":
        """A camera at a distance [m] from a point that it looks at."""
        away = np.array([cos(turn), sin(turn), 0.42])
        position = middle + away / np.linalg.norm(away) * distance
        return cls(tuple(position.tolist()), tuple(middle.tolist()))

    def rays(self, width: int, height: int) -> NDArray[np.float64]:
        """Its position, the direction through the raster's corner, and its change for a pixel right and down, shape (4, 3)."""
        right, down, forward = self.axes()
        sample = 2.0 * tan(self.fov / 2.0) / height
        corner = forward - right * (sample * width / 2.0) - down * (sample * height / 2.0)
        return np.array([self.position, corner, right * sample, down * sample])

    def view(self, width: int, height: int) -> NDArray[np.float64]:
        """The projection of a point in the base frame to x * depth, y * depth [pixel m] and depth [m], shape (3, 4)."""
        right, down, forward = self.axes()
        scale = height / (2.0 * tan(self.fov / 2.0))
        rows = np.array([scale * right + width / 2.0 * forward, scale * down + height / 2.0 * forward, forward])
        return np.column_stack([rows, -rows @ np.array(self.position)])

    def place(self, point: ArrayLike, width: int, height: int) -> tuple[float, float]:
        """The place in the picture [pixels x, y] of a point in the base frame [m]."""
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


def sun_view(direction: ArrayLike, middle: ArrayLike, radius: float, texels: int) -> NDArray[np.float64]:
    """The projection of points to the shadow map of a sun, which covers a radius [m] around a point, shape (3, 4).

    The third row is the height towards the sun [m], above zero within twice the radius of the point.
    """
    towards = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    scale = texels / (2.0 * radius)
    rows = np.array([scale * right, scale * np.cross(towards, right), towards])
    return np.column_stack([rows, np.array([texels / 2.0, texels / 2.0, 2.0 * radius]) - rows @ np.asarray(middle)])
