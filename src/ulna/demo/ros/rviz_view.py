"""Projects points of the scene into RViz's window, by the camera of ``demo.rviz``."""

from importlib.resources import files

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from ulna.description.pose import inverse

CONFIG = files("ulna.demo.ros") / "demo.rviz"
BACKGROUND = (246, 247, 249)  # as in demo.rviz
LEAST_BACKGROUND = 200_000  # its pixels, if RViz is on the screen


def scene_is_seen(image: NDArray) -> bool:
    """Whether a picture of the screen, shape (height, width, 3), shows RViz with its background."""
    return int(np.count_nonzero((image == BACKGROUND).all(axis=-1))) > LEAST_BACKGROUND


class View:
    """The pinhole camera of the configuration, in the part of the window that shows the background.

    Args:
        image: The screen, shape (height, width, 3), once ``scene_is_seen``.
    """

    def __init__(self, image: NDArray) -> None:
        rows, columns = np.nonzero((image == BACKGROUND).all(axis=-1))
        self.left, self.right, self.top, self.bottom = columns.min(), columns.max() + 1, rows.min(), rows.max() + 1
        orbit = yaml.safe_load(CONFIG.read_text())["Visualization Manager"]["Views"]["Current"]
        self.fov = orbit["Field of View"]  # of the height
        focus = np.array([orbit["Focal Point"][axis] for axis in "XYZ"])
        pitch, yaw = orbit["Pitch"], orbit["Yaw"]
        back = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
        right = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
        self.T_base_camera = np.eye(4)
        self.T_base_camera[:3] = np.column_stack([right, np.cross(back, right), back, focus + orbit["Distance"] * back])

    def project(self, point: ArrayLike) -> NDArray[np.float64]:
        """The place [pixel x, y] of a point in the base frame [m]."""
        x, y, z = (inverse(self.T_base_camera) @ [*np.asarray(point), 1.0])[:3]
        focal = (self.bottom - self.top) / 2 / np.tan(self.fov / 2)
        return np.array([(self.left + self.right) / 2 - focal * x / z, (self.top + self.bottom) / 2 + focal * y / z])

    def around(self, image: NDArray, point: ArrayLike, half: int) -> NDArray:
        """The square of pixels around a point in the base frame [m], of half width ``half``."""
        x, y = self.project(point).round().astype(int)
        return image[y - half : y + half, x - half : x + half]
