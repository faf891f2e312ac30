"""Records the demo into a video or picture."""

from collections.abc import Sequence
from dataclasses import replace
from math import atan, tan

from ulna.demo.drawing import WORD_POSITION_IN_BASE, box_handles, light, movable_box
from ulna.demo.scenario import Demo
from ulna.demo.script import Moment, Script
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.painter import Caption, Ground, Picture
from ulna.viewer.film.recording import Form, Tell, report_nothing, write_pictures
from ulna.viewer.film.skin import Model
from ulna.viewer.palette import collision_boxes

DEMO_CAMERA = Camera(position=(1.45, 1.35, 0.95), look_at=(0.13, 0.02, 0.45), fov=0.72)  # the box stays in sight
DEMO_GROUND = Ground(middle=(0.1, 0.0, 0.4), radius=1.3)
DEMO_ASPECT = 1.3  # width by height: in a narrower picture the camera sees more above and below


def record_demo(form: Form, at: float | None = None, *, boxes: bool = True, tell: Tell = report_nothing) -> None:
    """Record the demo: the arm repeats its trajectory, the box goes round it, the light is red while they touch.

    Args:
        form: The format of the file.
        at: The time [s] that a single picture shows; that of the first contact unless given.
        boxes: Show the twelve collision boxes of the arm.
        tell: Called with the number of pictures done so far.

    Raises:
        InputError: ``at`` is outside the length of the demo, or the file is not a single picture.
        FileError: The file cannot be written.
    """
    if at is not None and not form.is_still:
        raise InputError("at", f"is for a single picture, a .png; {form.path.name} shows the whole demo")
    demo = Demo()
    script = Script(demo, form.seconds)
    at = 0.1 * form.seconds if at is None else at
    if not 0.0 <= at <= form.seconds:
        raise InputError("at", f"{at:g} s is not between 0 and {form.seconds:g} s")
    moments = [script.moment(at)] if form.is_still else script.moments(form.rate)
    camera = _widened(DEMO_CAMERA, form.size)
    record_pictures(form, demo.robot, [demo_picture(demo.robot, moment, camera, boxes=boxes) for moment in moments], tell)


def demo_picture(robot: Robot, moment: Moment, camera: Camera, *, boxes: bool = True) -> Picture:
    """One moment of the demo as seen by a camera."""
    panes = tuple(collision_boxes(robot, moment.report.touching)) if boxes else ()
    box = movable_box(robot, moment.T_base_box), *box_handles(robot, moment.T_base_box)
    solids = (*panes, *box, light(robot, moment.report))
    return Picture(moment.q, camera, solids, Caption(str(moment.report), WORD_POSITION_IN_BASE))


def record_pictures(form: Form, robot: Robot, pictures: Sequence[Picture], tell: Tell = report_nothing) -> None:
    """Write pictures of the demo into the file of a form."""
    write_pictures(form, Model(robot, pictures[0].solids), pictures, DEMO_GROUND, tell)


def _widened(camera: Camera, size: tuple[int, int]) -> Camera:
    """The camera with a larger field of view for a narrow picture, so that the width of the scene still fits."""
    narrow = max(DEMO_ASPECT * size[1] / size[0], 1.0)
    return replace(camera, fov=2 * atan(narrow * tan(camera.fov / 2)))
