"""Draws a robot, a world or a motion for a notebook, as a picture or a short film."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World, refuse_no_world
from ulna.description.arrays import as_count, as_switch, positive
from ulna.description.robot_description import Description, Link
from ulna.errors import InputError
from ulna.kinematics.positions import as_configuration
from ulna.notebook.recording import Recording
from ulna.planning.timing import Moment
from ulna.robot import Robot
from ulna.viewer.film.camera import Camera, View
from ulna.viewer.film.painter import Picture
from ulna.viewer.film.recording import (
    Form,
    ground_of,
    make_form,
    record_moving,
    solids_of_world,
    write_pictures,
)
from ulna.viewer.film.skin import BoundingBall, Model
from ulna.viewer.visuals import Visuals, outlines_near

Array = NDArray[np.float64]
_PICTURE, _FILM = (720, 480), (480, 320)  # [pixels] unless given
_LONGEST, _SHORTEST = 10.0, 0.5  # [s] bounds of the length of a film unless given, since the notebook stores it
_FILM_LARGE = (1280, 720)  # [pixels] of an .mp4, which is a separate file
_EMPTY = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]])  # [m] the framed corners for a world without objects


class Motion(Protocol):
    """A motion in time, as an ``ulna.Trajectory``."""

    @property
    def duration(self) -> float:
        """The duration [s]."""
        ...

    def at(self, t: ArrayLike) -> Moment:
        """The positions and their derivatives at times [s]."""
        ...


def show_robot(
    robot: Robot, q: ArrayLike | None, world: World | None, *, boxes: bool, size: tuple[int, int] | None, camera: View
) -> Recording:
    """Implementation of ``Robot.show``."""
    refuse_no_world(world)
    at, around = robot.home if q is None else as_configuration(q, robot.tree, "q"), _snapshot(world)
    boxes = as_switch("boxes", boxes)

    def write(form: Form) -> None:
        record_moving(form, robot, at[None], around, boxes=boxes)

    return _picture(write, size, camera, robot.name)


def show_world(world: World, *, size: tuple[int, int] | None, camera: View) -> Recording:
    """Implementation of ``World.show``."""
    around = world.copy()

    def write(form: Form) -> None:
        points = np.vstack(outlines_near(around, np.zeros(3), np.inf) or [_EMPTY])
        ball = BoundingBall.of(points)
        nothing = Robot(Description("world", (Link("world"),), ()))
        eye = Camera.framing(points, form.away, form.aspect)
        picture = Picture(nothing.home, eye, solids_of_world(nothing, around, ball))
        write_pictures(form, Model(nothing, Visuals({})), [picture], ground_of(ball))

    return _picture(write, size, camera, "a world")


def show_motion(
    motion: Motion,
    checker: Checker,
    world: World | None,
    *,
    seconds: float | None,
    boxes: bool,
    size: tuple[int, int] | None,
    camera: View,
) -> Recording:
    """Implementation of ``Trajectory.show``. checker: of the moving robot."""
    refuse_no_world(world)
    of, narrowed = checker.description, checker.tree.narrowed
    robot = Robot(of, attached=checker.attached, allowed=checker.user_pairs, _found=checker.sampled_pairs, _narrowed=narrowed)
    around, boxes = _snapshot(world), as_switch("boxes", boxes)
    length = min(max(motion.duration, _SHORTEST), _LONGEST) if seconds is None else positive("seconds", seconds, "a time [s]")

    def write(form: Form) -> None:
        times = np.linspace(0.0, motion.duration, max(form.n_frames, 2))
        record_moving(form, robot, motion.at(times).q, around, boxes=boxes)

    film = make_form(Path("film.gif"), length, _as_size(size or _FILM), camera=camera)

    def save(path: Path) -> None:
        large = _FILM_LARGE if path.suffix.lower() == ".mp4" and size is None else _as_size(size or _FILM)
        write(make_form(path, length, large, camera=camera))

    return Recording(_bytes_of(write, film), "gif", film.size, f"{robot.name} in motion", save)


def _picture(write: Callable[[Form], None], size: tuple[int, int] | None, camera: View, subject: str) -> Recording:
    picture = make_form(Path("picture.png"), 1.0, _as_size(size or _PICTURE), camera=camera)

    def save(path: Path) -> None:
        if path.suffix.lower() != ".png":
            raise InputError("path", f"{path.name!r} does not end in .png; this is a single picture")
        write(replace(picture, path=path))

    return Recording(_bytes_of(write, picture), "png", picture.size, subject, save)


def _bytes_of(write: Callable[[Form], None], form: Form) -> bytes:
    """The bytes of the file of a form, written to a temporary folder."""
    with TemporaryDirectory(prefix="ulna-") as folder:
        path = Path(folder, form.path)
        write(replace(form, path=path))
        return path.read_bytes()


def _snapshot(world: World | None) -> World:
    return World() if world is None else world.copy()


def _as_size(size: tuple[int, int]) -> tuple[int, int]:
    if not isinstance(size, tuple | list) or len(size) != 2:
        raise InputError("size", f"{size!r}; width and height [pixels] are expected, as in (720, 480)")
    width, height = (as_count("size", each, 16, 4096) for each in size)
    return width, height
