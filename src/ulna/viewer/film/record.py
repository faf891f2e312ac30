"""Records the demo, or a robot that stands still while the camera goes round it, into a file."""

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
from ulna.viewer.film.model import Extent, Model
from ulna.viewer.film.painter import Ground, Picture
from ulna.viewer.solid import collision_boxes

TURN_FROM = 0.75  # [rad] about z from x: where the camera stands that goes round a robot
LARGEST_SIZE, MOST_FRAMES = 4096, 20_000
FINE_PIXELS = 1920 * 1080  # up to which a single picture has more samples a pixel
Tell = Callable[[int], object]


def _no_one(done: int) -> None:
    """Nobody is told."""


@dataclass(frozen=True)
class Form:
    """What a file is to be like.

    Attributes:
        path: Where it is written; its ending says what it is: .mp4, .gif or .png.
        seconds: How long it is.
        size: Width and height [pixels]; the sides of a video are made even.
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
        """How many pictures it has."""
        return 1 if self.is_still else max(round(self.seconds * self.rate), 1)


def make_form(path: Path, seconds: float, size: tuple[int, int] | None = None, rate: int | None = None) -> Form:
    """A form whose parts go together; a moving .gif is small and slow unless said otherwise.

    Raises:
        InputError: One of them cannot be had.
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
        raise InputError("rate", f"{rate}; 1 to {50 if is_gif else 120} pictures a second can be had")
    if not (0.0 < seconds < inf and (ending == ".png" or seconds * rate <= MOST_FRAMES)):
        raise InputError("seconds", f"{seconds:g}; more than 0 s and at most {MOST_FRAMES} pictures can be had")
    if ending == ".mp4":
        width, height = width + width % 2, height + height % 2  # H.264 halves the colours' raster
    return Form(path, seconds, (width, height), rate)


def record_robot(
    form: Form, robot: Robot, q: NDArray[np.float64], *, boxes: bool = True, tell: Tell = _no_one
) -> tuple[str, ...]:
    """A robot that stands at q, while the camera goes round it once. Given back: why which meshes could not be shown."""
    solids = tuple(collision_boxes(robot)) if boxes else ()
    model = Model(robot, solids)
    extent = model.extent(q)
    aspect = form.size[0] / form.size[1]
    turns = TURN_FROM + 2 * pi * np.arange(form.n_frames) / form.n_frames
    pictures = [Picture(q, Camera.around(extent.middle, extent.radius, turn, aspect), solids) for turn in turns]
    _write(form, model, pictures, _ground(extent), tell)
    return model.missing


def _write(form: Form, model: Model, pictures: Sequence[Picture], ground: Ground, tell: Tell) -> None:
    samples = 4 if form.is_still and form.size[0] * form.size[1] <= FINE_PIXELS else 2
    film = Film(model, pictures, form.size, form.rate, ground, samples, tell)
    write_film(form.path, film)


def _ground(extent: Extent) -> Ground:
    """A floor under the lowest point, or at the base if that is lower; its cells are about a tenth of the robot's size."""
    cell = 10.0 ** np.round(np.log10(max(extent.radius, 1e-3) / 6.0))
    return Ground(tuple(extent.middle.tolist()), 1.5 * extent.radius, min(extent.lowest, 0.0), float(cell))
