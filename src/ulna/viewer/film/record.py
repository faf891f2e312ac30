"""Records pictures into a file: of a robot while the camera goes round it, or given ones."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError, did_you_mean
from ulna.robot import Robot
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.files import WRITERS, write_film
from ulna.viewer.film.film import Film
from ulna.viewer.film.model import BoundingBall, Model
from ulna.viewer.film.painter import Ground, Picture
from ulna.viewer.solid import collision_boxes

TURN_FROM = 0.75  # [rad] about z from x: where the camera starts to go round a robot
LARGEST_SIZE, MOST_FRAMES = 4096, 20_000
FINE_PIXELS = 1920 * 1080  # a single picture of at most so many pixels has more samples a pixel
Tell = Callable[[int], object]


def report_nothing(done: int) -> None:
    """Ignore the progress."""


@dataclass(frozen=True)
class Form:
    """The format of a video or picture file.

    Attributes:
        path: Its path, which ends in .mp4, .gif or .png.
        seconds: Its length [s].
        size: Width and height [pixels]; those of a video are even.
        rate: Pictures a second.
    """

    path: Path
    seconds: float
    size: tuple[int, int]
    rate: int

    @property
    def is_still(self) -> bool:
        """True for a single picture."""
        return self.path.suffix.lower() == ".png"

    @property
    def n_frames(self) -> int:
        """The number of its pictures."""
        return 1 if self.is_still else max(round(self.seconds * self.rate), 1)


def make_form(path: Path, seconds: float, size: tuple[int, int] | None = None, rate: int | None = None) -> Form:
    """A form with defaults by its file's ending: 1280x720 at 30 pictures a second, or 640x360 at 10 for a .gif.

    Raises:
        InputError: The ending is unknown, or the length, the size or the rate is out of range.
    """
    ending = path.suffix.lower()
    if ending not in WRITERS:
        raise InputError("path", f"{path.name!r} ends in none of {', '.join(WRITERS)}{did_you_mean(ending, WRITERS)}")
    is_gif = ending == ".gif"
    width, height = size or ((640, 360) if is_gif else (1280, 720))
    rate = (10 if is_gif else 30) if rate is None else rate
    if not (16 <= width <= LARGEST_SIZE and 16 <= height <= LARGEST_SIZE):
        raise InputError("size", f"{width}x{height}; each side has 16 to {LARGEST_SIZE} pixels")
    if not 1 <= rate <= (50 if is_gif else 120):
        raise InputError("rate", f"{rate}; 1 to {50 if is_gif else 120} pictures a second are expected")
    if not (0.0 < seconds < inf and (ending == ".png" or seconds * rate <= MOST_FRAMES)):
        raise InputError("seconds", f"{seconds:g}; a length above 0 s with at most {MOST_FRAMES} pictures is expected")
    if ending == ".mp4":
        width, height = width + width % 2, height + height % 2  # H.264 halves the colours' raster
    return Form(path, seconds, (width, height), rate)


def record_robot(
    form: Form, robot: Robot, q: NDArray[np.float64], *, boxes: bool = True, tell: Tell = report_nothing
) -> tuple[str, ...]:
    """Record a robot at one q, while the camera goes round it once.

    Args:
        form: The format of the file.
        robot: The robot.
        q: Its joint positions [rad or m], shape (n_dof,).
        boxes: Show its collision boxes.
        tell: Called with the number of pictures done so far.

    Returns:
        The meshes that could not be shown, each with the reason.

    Raises:
        FileError: The file cannot be written.
    """
    solids = tuple(collision_boxes(robot)) if boxes else ()
    model = Model(robot, solids)
    ball = model.bounding_ball(q)
    aspect = form.size[0] / form.size[1]
    turns = TURN_FROM + 2 * pi * np.arange(form.n_frames) / form.n_frames
    pictures = [Picture(q, Camera.around(ball.centre, ball.radius, turn, aspect), solids) for turn in turns]
    write_pictures(form, model, pictures, ground_of(ball), tell)
    return model.missing


def write_pictures(form: Form, model: Model, pictures: Sequence[Picture], ground: Ground, tell: Tell = report_nothing) -> None:
    """Paint pictures of a model, and write them into the file that a form describes.

    Raises:
        FileError: The file cannot be written.
    """
    samples = 4 if form.is_still and form.size[0] * form.size[1] <= FINE_PIXELS else 2
    film = Film(model, pictures, form.size, form.rate, ground, samples, tell)
    write_film(form.path, film)


def ground_of(ball: BoundingBall) -> Ground:
    """A floor under the lowest point, or at the base if that is lower; its cells are about a tenth of the robot's size."""
    cell = 10.0 ** np.round(np.log10(max(ball.radius, 1e-3) / 6.0))
    return Ground(tuple(ball.centre.tolist()), 1.5 * ball.radius, min(ball.lowest, 0.0), float(cell))
