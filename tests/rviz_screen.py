"""RViz on a screen of its own, seen and touched as by a person: pixels, the mouse, and where a point of the scene appears."""

import contextlib
import io
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from processes import running
from ulna.description.pose import inverse

CONFIG = Path(__file__).parents[1] / "src" / "ulna" / "demo" / "ros" / "demo.rviz"
BACKGROUND = (246, 247, 249)


@contextlib.contextmanager
def screen() -> Iterator["Screen"]:
    """An X server with one screen; it picks its number itself."""
    reader, writer = os.pipe()
    command = ("Xvfb", "-displayfd", str(writer), "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset")
    with running(*command, pass_fds=[writer], stderr=subprocess.DEVNULL):
        os.close(writer)
        with os.fdopen(reader) as numbers:
            yield Screen(f":{numbers.readline().strip()}")


@dataclass(frozen=True)
class Screen:
    """An X display."""

    name: str

    def pixels(self) -> np.ndarray:
        """What it shows, shape (height, width, 3), 0..255."""
        shot = subprocess.run(["import", "-display", self.name, "-window", "root", "png:-"], capture_output=True, check=True)
        return np.asarray(Image.open(io.BytesIO(shot.stdout)).convert("RGB")).astype(int)

    def mouse(self, *words: object) -> None:
        """One command of xdotool."""
        subprocess.run(
            ["xdotool", *map(str, words)], env={**os.environ, "DISPLAY": self.name}, check=True, stderr=subprocess.DEVNULL
        )

    def drag(self, start: np.ndarray, end: np.ndarray) -> None:
        """Press at one place [pixel x, y], move on to another in small steps, and let go."""
        self.mouse("mousemove", *start.astype(int), "sleep", 0.3, "mousedown", 1, "sleep", 0.2)
        self.mouse(*(word for p in np.linspace(start, end, 20).astype(int) for word in ("mousemove", *p, "sleep", 0.05)))
        self.mouse("sleep", 0.2, "mouseup", 1)


class View:
    """Where points of the scene appear: the pinhole that the configuration describes, in the part of the window that it fills."""

    def __init__(self, image: np.ndarray) -> None:
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

    def project(self, point) -> np.ndarray:
        """Where a point of the base frame [m] appears [pixel x, y]."""
        x, y, z = (inverse(self.T_base_camera) @ [*point, 1.0])[:3]
        focal = (self.bottom - self.top) / 2 / np.tan(self.fov / 2)
        return np.array([(self.left + self.right) / 2 - focal * x / z, (self.top + self.bottom) / 2 + focal * y / z])

    def around(self, image: np.ndarray, point, half: int) -> np.ndarray:
        """The square of pixels about a point of the base frame."""
        x, y = self.project(point).round().astype(int)
        return image[y - half : y + half, x - half : x + half]
