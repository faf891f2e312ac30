"""RViz on a screen of its own, seen and touched as by a person: pixels and the mouse."""

import contextlib
import io
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from PIL import Image

from processes import running


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
