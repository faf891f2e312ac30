"""Starts an X display without a monitor, by Xvfb; sees its pixels and moves its pointer, by xdotool."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import av
import numpy as np
from numpy.typing import NDArray

from ulna.errors import MissingROSError

SIZE = (1280, 800)  # pixels: demo.rviz fills it
_END_WITHIN_S = 5.0


@contextmanager
def virtual_screen() -> Iterator["VirtualScreen"]:
    """A context with a display; the server chooses its number.

    Raises:
        MissingROSError: Xvfb does not start.
    """
    reader, writer = os.pipe()
    command = ("Xvfb", "-displayfd", str(writer), "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-nolisten", "tcp", "-noreset")
    server = subprocess.Popen(command, pass_fds=[writer], stderr=subprocess.DEVNULL, start_new_session=True)  # noqa: S603
    os.close(writer)
    try:
        with os.fdopen(reader) as numbers:
            number = numbers.readline().strip()
        if not number:
            raise MissingROSError(f"Xvfb has ended (status {server.wait()}); {' '.join(command)} says why")
        yield VirtualScreen(f":{number}")
    finally:
        server.terminate()
        try:
            server.wait(_END_WITHIN_S)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()


@dataclass(frozen=True)
class VirtualScreen:
    """A display; ``name`` is the value of DISPLAY for it."""

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
