"""Opens pages in headless Chromium, reads their pixels and drags what they show."""

import io

import numpy as np
from PIL import Image
from playwright.sync_api import Page

from colors import count
from processes import wait_for

FLAGS = (
    "--no-sandbox",
    "--disable-gpu-rasterization",  # without a GPU these two cost a third of a picture
    "--disable-gpu-compositing",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--webgl-antialiasing-mode=none",  # drawn by the CPU, smoothed edges cost 16 times as much: 1.3 frames a second, 21 without
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
SIZE = (1280, 800)
COARSE = 0.4  # pixels that viser draws of the scene, by those of the page: drawn by a CPU a picture costs by its pixels


_TWO_FRAMES = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def wait_to_see(page: Page, condition, what: str):
    """Wait until something holds on a page, and return it. Between two looks the page draws itself anew, however slowly."""

    def pause():
        page.evaluate(_TWO_FRAMES)
        page.wait_for_timeout(100)

    return wait_for(condition, what, pause=pause)


def pixels(page: Page) -> np.ndarray:
    """What the page shows, shape (height, width, 3), 0..255."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)


def camera_of(page: Page, server):
    """The camera of a server's only tab, once the page has put it where the server says: a tab begins with one of its own."""
    (client,) = wait_to_see(page, lambda: list(server.get_clients().values()), "a tab")
    wanted = server.initial_camera.look_at
    wait_to_see(page, lambda: np.allclose(client.camera.look_at, wanted, atol=1e-3), "the camera where it begins")
    return client.camera


def project(camera, point) -> np.ndarray:
    """Where a point of the scene appears [pixel x, y]: a pinhole that looks along the camera's z axis."""
    from ulna.description.pose import inverse, pose

    x, y, z = (inverse(pose(camera.position, wxyz=camera.wxyz)) @ [*point, 1.0])[:3]
    width, height = camera.image_width / COARSE, camera.image_height / COARSE  # of the scene: the panel is beside it
    focal = height / 2 / np.tan(camera.fov / 2)
    return np.array([width / 2 + focal * x / z, height / 2 + focal * y / z])


def around(image: np.ndarray, center, half: int) -> np.ndarray:
    """The square of pixels about a point."""
    x, y = (round(v) for v in center)
    return image[y - half : y + half, x - half : x + half]


def drag(page, handles, start, way, color, steps=12):
    """Drag the head of an arrow, once it is seen where it should be, until the server has heard of the last step."""
    wait_to_see(page, lambda: count(around(pixels(page), start, 8), color) >= 10, f"a {color} arrow")
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, steps + 1):
        page.mouse.move(start[0] + way[0] * k / steps, start[1] + way[1] * k / steps)
        page.wait_for_timeout(30)
    wait_to_see(page, lambda: handles.dragged, "handles that are held")
    places = [None]

    def rests():
        places.append(handles.pose)
        return places[-2] is not None and np.array_equal(places[-1], places[-2])

    wait_to_see(page, rests, "the last step of the drag")


def arrow(camera, T, axis, size):
    """Where the head of an arrow of some handles is seen."""
    return project(camera, T[:3, 3] + 0.95 * size * T[:3, axis])
