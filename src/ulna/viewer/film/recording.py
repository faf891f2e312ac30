"""Records a robot to a file, while the camera circles it or while it moves among obstacles."""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import cycle
from math import inf, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.collision.attached import Attached
from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.pose import matrix_from_rotation_vector
from ulna.description.shapes import Box, HalfSpace
from ulna.errors import GeometryError, InputError, did_you_mean
from ulna.robot import Robot
from ulna.viewer.film.camera import FILM_FROM, Camera, View, direction_to
from ulna.viewer.film.film import WRITERS, Film, write_film
from ulna.viewer.film.painter import Ground, Picture
from ulna.viewer.film.skin import BoundingBall, Model
from ulna.viewer.palette import FREE, GROUND, OBSTACLES, TOUCHING, Color, Solid, collision_solids
from ulna.viewer.visuals import outlines_near, touching_links

_CACHED_MODELS = 2  # robots whose models are cached
LARGEST_SIZE, MAX_FRAMES = 4096, 20_000
FINE_PIXELS = 1920 * 1080  # a single picture of at most so many pixels has more samples per pixel
Tell = Callable[[int], object]


def report_nothing(done: int) -> None:
    """Ignore the progress."""


@dataclass(frozen=True)
class Form:
    """The format of a video or picture file, and the place of the camera.

    Attributes:
        path: The path of the file, which ends in .mp4, .gif or .png.
        seconds: The length of the film [s].
        size: Width and height [pixels]; even numbers for a video.
        rate: Pictures per second.
        away: The direction from the scene to the camera; where the camera circles the scene, to its first place.
    """

    path: Path
    seconds: float
    size: tuple[int, int]
    rate: int
    away: tuple[float, float, float] = FILM_FROM

    @property
    def aspect(self) -> float:
        """Width by height."""
        return self.size[0] / self.size[1]

    @property
    def is_still(self) -> bool:
        """Whether the file is a single picture."""
        return self.path.suffix.lower() == ".png"

    @property
    def n_frames(self) -> int:
        """The number of pictures."""
        return 1 if self.is_still else max(round(self.seconds * self.rate), 1)


def make_form(
    path: Path, seconds: float, size: tuple[int, int] | None = None, rate: int | None = None, camera: View = None
) -> Form:
    """A form with defaults: 1280x720 at 30 Hz, or 640x360 at 10 Hz for a .gif.

    camera: see ``direction_to``.

    Raises:
        InputError: The ending is unknown, or the length, the size, the rate or the camera is out of range.
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
    if not (0.0 < seconds < inf and (ending == ".png" or seconds * rate <= MAX_FRAMES)):
        raise InputError("seconds", f"{seconds:g}; a length above 0 s with at most {MAX_FRAMES} pictures is expected")
    if ending == ".mp4":
        width, height = width + width % 2, height + height % 2  # H.264 halves the raster of the colors
    return Form(path, seconds, (width, height), rate, direction_to(camera))


@lru_cache(_CACHED_MODELS)
def model_of(robot: Robot) -> Model:
    """The triangles of a robot, cached for its next picture, since reading meshes takes seconds."""
    return Model(robot)


def record_robot(
    form: Form, robot: Robot, q: NDArray[np.float64], *, boxes: bool = True, tell: Tell = report_nothing
) -> tuple[str, ...]:
    """Record a robot at one q, while the camera circles it once.

    Args:
        form: The format of the file.
        robot: The robot.
        q: Its joint positions [rad or m], shape (n_dof,).
        boxes: Whether to show its collision shapes.
        tell: Called with the number of finished pictures.

    Returns:
        The meshes that could not be shown, each with the reason.

    Raises:
        FileError: The file cannot be written.
    """
    solids = tuple(collision_solids(robot)) if boxes else ()
    model = model_of(robot)
    ball = BoundingBall.of(model.points_at(q))
    turns = [matrix_from_rotation_vector((0.0, 0.0, turn)) for turn in 2 * pi * np.arange(form.n_frames) / form.n_frames]
    pictures = [Picture(q, Camera.around(ball.center, ball.radius, R @ form.away, form.aspect), solids) for R in turns]
    write_pictures(form, model, pictures, ground_of(ball), tell)
    return model.missing


def write_pictures(form: Form, model: Model, pictures: Sequence[Picture], ground: Ground, tell: Tell = report_nothing) -> None:
    """Paint pictures of a model, and write them to the file of a form.

    Raises:
        FileError: The file cannot be written.
    """
    samples = 4 if form.is_still and form.size[0] * form.size[1] <= FINE_PIXELS else 2
    film = Film(model, pictures, form.size, form.rate, ground, samples, tell)
    write_film(form.path, film)


def ground_of(ball: BoundingBall) -> Ground:
    """A floor under the lowest point and the base, with cells of about a tenth of the size."""
    cell = 10.0 ** np.round(np.log10(max(ball.radius, 1e-3) / 6.0))
    return Ground(tuple(ball.center.tolist()), 1.5 * ball.radius, min(ball.lowest, 0.0), float(cell))


Array = NDArray[np.float64]
_FAR = 4.0  # [radii of the robot] the picture leaves out obstacles farther away
_THICKNESS = 0.004  # [m] of the slab that is drawn for a half-space


def record_moving(
    form: Form, robot: Robot, path: Array, world: World, *, boxes: bool = True, tell: Tell = report_nothing
) -> tuple[str, ...]:
    """Record a robot along a path of q, shape (n, n_dof), evenly spaced in time.

    Links and obstacles in contact are red. The other arguments and the result are those of ``record_robot``.

    Raises:
        FileError: The file cannot be written.
    """
    origins = np.vstack([robot.link_poses(q)[:, :3, 3] for q in _sample_path(path, min(len(path), 16))])
    middle = BoundingBall.of(origins)
    shots = [(q, report_at(robot, q, world)) for q in _sample_path(path, form.n_frames)]
    model = model_of(robot)
    own = np.vstack([model.points_at(q) for q in _sample_path(path, min(len(path), 16))])
    low, high = own.min(axis=0), own.max(axis=0)
    points = np.vstack([own, *outlines_near(world, (low + high) / 2, _FAR * np.max(high - low) / 2)])
    camera, ground = Camera.framing(points, form.away, form.aspect), ground_of(BoundingBall.of(points))
    pictures = [
        Picture(q, camera, solids_at(robot, report, world, middle, boxes=boxes), touching=touching_links(robot, report))
        for q, report in shots
    ]
    write_pictures(form, model, pictures, ground, tell)
    return model.missing


def _sample_path(path: Array, n: int) -> Iterator[Array]:
    """Yield n evenly spaced configurations from the first row to the last, interpolated linearly."""
    for place in np.linspace(0.0, len(path) - 1, n) if n > 1 else [0.0]:
        k = min(int(place), max(len(path) - 2, 0))
        yield path[k] + (place - k) * (path[min(k + 1, len(path) - 1)] - path[k])


def solids_at(robot: Robot, report: Report, world: World, middle: BoundingBall, *, boxes: bool) -> tuple[Solid, ...]:
    """The robot's collision shapes, its attached objects and the obstacles, each in its own color, or red if in contact."""
    panes = collision_solids(robot, report.touching) if boxes else ()
    held = [_attached(each, touching=each.name in report.touching) for each in robot.attached]
    hit = {pair.name_b for pair in report.pairs if pair.link_b is None and pair.signed_distance <= 0.0}
    return (*panes, *held, *solids_of_world(robot, world, middle, hit))


def solids_of_world(robot: Robot, world: World, middle: BoundingBall, hit: Collection[str] = ()) -> tuple[Solid, ...]:
    """The obstacles, each in its own color, or red if its name is in ``hit``."""
    colored = zip(world.items(), cycle(OBSTACLES))
    return tuple(_obstacle(robot, *each, TOUCHING if each[0] in hit else color, middle) for each, color in colored)


def report_at(robot: Robot, q: Array, world: World) -> Report:
    """The collision report; empty if the robot's shapes cannot be checked."""
    try:
        return robot.check_collision(q, world)
    except GeometryError:
        return Report(())


def _attached(held: Attached, *, touching: bool) -> Solid:
    return Solid(f"attached {held.name}", held.link, held.T_link_object, held.shape, TOUCHING if touching else FREE)  # type: ignore[type-var]


def _obstacle(robot: Robot, name: str, shape: object, T: Array, color: Color, middle: BoundingBall) -> Solid:
    """The drawing of an obstacle. A half-space is drawn as a slab under its surface, centered below the robot."""
    if isinstance(shape, HalfSpace):
        pose, z, side = T.copy(), T[:3, 2], 3.0 * middle.radius  # small enough that no corner is behind the camera
        pose[:3, 3] = middle.center - z * ((middle.center - T[:3, 3]) @ z + _THICKNESS / 2)
        shape, color = Box((side, side, _THICKNESS)), color if color == TOUCHING else GROUND
    else:
        pose = T
    return Solid(f"obstacle {name}", robot.base, pose, shape, color)  # type: ignore[type-var]
