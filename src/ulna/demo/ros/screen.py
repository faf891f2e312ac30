"""Provides a virtual screen to record RViz: its pixels and pointer, and the camera of ``demo.rviz``."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files

import av
import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from ulna.demo.ros.children import Children
from ulna.errors import MissingROSError
from ulna.viewer.film.camera import Camera

SIZE = (1280, 800)  # pixels; demo.rviz fills the screen
CONFIG = files("ulna.demo.ros") / "demo.rviz"
BACKGROUND = (246, 247, 249)  # as in demo.rviz
MIN_BACKGROUND = 200_000  # its pixels if RViz is on the screen


@contextmanager
def virtual_screen() -> Iterator["VirtualScreen"]:
    """A context with a display, by Xvfb; the server chooses its number."""
    reader, writer = os.pipe()
    command = ("Xvfb", "-displayfd", str(writer), "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-nolisten", "tcp", "-noreset")
    with Children() as programs, os.fdopen(reader) as numbers:
        try:
            programs.start("Xvfb", *command, quiet=True, pass_fds=(writer,))
        finally:
            os.close(writer)
        number = numbers.readline().strip()
        if not number:
            raise MissingROSError(f"Xvfb has ended; {' '.join(command)} says why")
        yield VirtualScreen(f":{number}")


@dataclass(frozen=True)
class VirtualScreen:
    """A display, whose pointer xdotool moves; ``name`` is the value of DISPLAY for it."""

    name: str

    def pixels(self) -> NDArray[np.uint8]:
        """A screenshot with the pointer, shape (height, width, 3)."""
        options = {"video_size": f"{SIZE[0]}x{SIZE[1]}", "draw_mouse": "1"}
        with av.open(self.name, format="x11grab", options=options) as screen:
            return np.asarray(next(screen.decode(video=0)).to_ndarray(format="rgb24"), np.uint8)

    def move_mouse(self, place: NDArray[np.float64]) -> None:
        """Move the pointer to a place [pixel x, y]."""
        where = map(str, place.round().astype(int))
        environment = {**os.environ, "DISPLAY": self.name}
        subprocess.run(["xdotool", "mousemove", *where], env=environment, check=True, stderr=subprocess.DEVNULL)  # noqa: S603, S607


def scene_is_seen(image: NDArray) -> bool:
    """Whether a picture of the screen, shape (height, width, 3), shows RViz with its background."""
    return int(np.count_nonzero((image == BACKGROUND).all(axis=-1))) > MIN_BACKGROUND


class View:
    """The pinhole camera of the configuration, in the part of the window that shows the background.

    Args:
        image: The screen, shape (height, width, 3), once ``scene_is_seen``.
    """

    def __init__(self, image: NDArray) -> None:
        rows, columns = np.nonzero((image == BACKGROUND).all(axis=-1))
        self._corner = np.array([columns.min(), rows.min()])
        self._size = int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1
        orbit = yaml.safe_load(CONFIG.read_text())["Visualization Manager"]["Views"]["Current"]
        focus, pitch, yaw = np.array([orbit["Focal Point"][axis] for axis in "XYZ"]), orbit["Pitch"], orbit["Yaw"]
        back = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
        place = focus + orbit["Distance"] * back
        self._camera = Camera(tuple(place.tolist()), tuple(focus.tolist()), orbit["Field of View"])  # vertical field of view

    def project(self, point: ArrayLike) -> NDArray[np.float64]:
        """The place [pixel x, y] of a point in the base frame [m]."""
        return self._corner + self._camera.place(point, *self._size)

    def around(self, image: NDArray, point: ArrayLike, half: int) -> NDArray:
        """The square of pixels around a point in the base frame [m], of half width ``half``."""
        x, y = self.project(point).round().astype(int)
        return image[y - half : y + half, x - half : x + half]
