"""A real page of the demo in headless Chromium, and what its pixels show."""

import io
import time
from collections.abc import Callable

import numpy as np
from PIL import Image
from playwright.sync_api import Page

FLAGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
SIZE = (1280, 800)
PATIENCE_S = 60.0  # for software rendering on a busy machine


def pixels(page: Page) -> np.ndarray:
    """What the page shows, shape (height, width, 3), 0..255."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)


def project(camera, point) -> np.ndarray:
    """Where a point of the scene appears [pixel x, y]: a pinhole that looks along the camera's z axis."""
    from ulna.model.pose import inverse, pose

    x, y, z = (inverse(pose(camera.position, wxyz=camera.wxyz)) @ [*point, 1.0])[:3]
    focal = SIZE[1] / 2 / np.tan(camera.fov / 2)
    return np.array([SIZE[0] / 2 + focal * x / z, SIZE[1] / 2 + focal * y / z])


def around(image: np.ndarray, centre, half: int) -> np.ndarray:
    """The square of pixels about a point."""
    x, y = (round(v) for v in centre)
    return image[y - half : y + half, x - half : x + half]


def count(image: np.ndarray, like: str) -> int:
    """How many pixels are clearly "red", "green" or "blue"."""
    k = ("red", "green", "blue").index(like)
    others = np.delete(image, k, axis=-1).max(axis=-1)
    return int(np.count_nonzero(image[..., k] - others > 60))


def wait_for(condition: Callable[[], bool], what: str) -> None:
    """Wait until something is seen."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, f"not seen within {PATIENCE_S:g} s: {what}"
        time.sleep(0.1)
