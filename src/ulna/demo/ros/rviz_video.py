"""Records the demo in RViz on a virtual screen, while the box is dragged by its arrows and a ring.

The video is made frame by frame. The arm advances by a tenth of a second and the box by a step. The frame is taken once RViz has
drawn both, with the light. So the video has the right speed on a slow machine too. The box is moved by the messages that RViz
publishes during a drag, and the pointer moves along. A mouse alone may miss: RViz looks under the pointer only once per frame.
While it draws slowly, it may take a press on an arrow for a press on its neighbor.
"""

# pyright: reportMissingImports=false

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib.resources import as_file
from pathlib import Path
from typing import TypeVar, cast

import numpy as np
import rospy
from numpy.typing import NDArray
from visualization_msgs.msg import InteractiveMarkerFeedback

from ulna.demo.ros import messages
from ulna.demo.ros.children import Children
from ulna.demo.ros.drags import DRAGS, Step, steps
from ulna.demo.ros.ros1 import ArmAndLight, MovableBox, node
from ulna.demo.ros.ros1_demo import MasterPrograms, have_master, restart_ended
from ulna.demo.ros.screen import CONFIG, SIZE, View, VirtualScreen, scene_is_seen, virtual_screen
from ulna.demo.scenario import BOX_NAME, BOX_START, LIGHT_POSITION, RATE_HZ, Demo, light_color
from ulna.errors import InputError, MissingROSError, UlnaError
from ulna.viewer.compiler import Compiler
from ulna.viewer.film.film import Film, write_film
from ulna.viewer.palette import RED

# The programs, and Debian's packages that contain them.
_NEEDED = {"rosmaster": "python3-rosmaster", "rviz": "rviz", "Xvfb": "xvfb", "xdotool": "xdotool"}
MIN_SECONDS = 6.0  # a few pictures for each drag
_APPEARS_WITHIN_S = 120.0
_DRAWS_WITHIN_S = 5.0  # [s], for changes that cannot be seen, such as an arm behind the box
_LOOK_S = 0.05  # [s], interval between screenshots
_LIGHT_PIXELS, _BOX_PIXELS = 200, 400  # number of pixels of their colors, if visible
_QUEUE = 10  # messages: more than the events of one step
Image = NDArray[np.uint8]
_T = TypeVar("_T")


def record_rviz(path: Path, seconds: float, compiler: Compiler, tell: Callable[[int], object] = lambda _: None) -> None:
    """Record the demo in RViz as an .mp4 of ten pictures per second, and end all programs that it started."""
    if path.suffix.lower() != ".mp4":
        raise InputError("path", f"{path.name!r}; RViz is recorded as an .mp4")
    if not MIN_SECONDS <= seconds <= 3600.0:
        raise InputError("seconds", f"{seconds:g}; {MIN_SECONDS:g} to 3600 s are expected: the box is dragged {len(DRAGS)} times")
    _refuse_missing()
    demo = Demo()
    with ExitStack() as stack:
        screen = stack.enter_context(virtual_screen())
        os.environ["DISPLAY"] = screen.name
        master = stack.enter_context(Children())
        have_master(master)
        ended = stack.enter_context(node("ulna_video"))
        programs = stack.enter_context(MasterPrograms(demo, str(stack.enter_context(as_file(CONFIG)))))
        programs.meet_master()

        def keep() -> None:
            if ended():
                raise KeyboardInterrupt
            restart_ended(master, programs)

        pictures = Screencast(screen, demo, compiler, round(seconds * RATE_HZ), keep, tell)
        write_film(path, cast("Film", pictures))  # an .mp4 takes its frames, size and rate


def _refuse_missing() -> None:
    missing = [program for program in _NEEDED if shutil.which(program) is None]
    if missing:
        packages = " ".join(_NEEDED[program] for program in missing)
        raise MissingROSError(f"not on this machine: {', '.join(missing)}; on Debian: apt-get install {packages}")


class RVizError(UlnaError, RuntimeError):
    """RViz does not show the scene."""


class Screencast:
    """The frames of RViz in the interface that ``write_film`` needs.

    Args:
        screen: The display of RViz.
        demo: The arm and the box.
        compiler: Compiles the kernels before the first frame.
        n: The number of frames.
        keep: Called often; it restarts RViz after a crash, and raises KeyboardInterrupt if the node is to end.
        tell: Called with the number of frames done.

    Attributes:
        size, rate: Width and height [pixels]; pictures per second.
    """

    size, rate = SIZE, round(RATE_HZ)

    def __init__(
        self,
        screen: VirtualScreen,
        demo: Demo,
        compiler: Compiler,
        n: int,
        keep: Callable[[], object],
        tell: Callable[[int], object],
    ) -> None:
        self._screen, self._compiler, self._n, self._keep, self._tell = screen, compiler, n, keep, tell
        self._arm, self._box = ArmAndLight(demo, compiler.ask), MovableBox(demo.robot)
        self._drags = rospy.Publisher(f"/{messages.SERVER}/feedback", InteractiveMarkerFeedback, queue_size=_QUEUE)

    def __len__(self) -> int:
        return self._n

    def frames(self) -> Iterator[Image]:
        """Play the demo, drag the box, and yield each frame, shape (height, width, 3)."""
        while self._arm.player.report is None or self._compiler.names:
            self._pause()
        view, image = self._wait_for_scene()
        for k, step in enumerate(steps(self._n)):
            if step is not None:
                self._screen.move_mouse(view.project(step.pointer))
                image = self._screen.pixels()  # with the pointer in place: only RViz changes the screen from here on
                self._drag(step)
            self._arm.player.advance(1.0 / RATE_HZ)
            image = self._drawn(view, image)
            self._tell(k + 1)
            yield image

    def _wait_for_scene(self) -> tuple[View, Image]:
        """The view and the pixels of RViz's window, once it shows light and box, and drags reach the nodes."""

        def look() -> tuple[View, Image] | None:
            image = self._screen.pixels()
            if not self._drags.get_num_connections() or not scene_is_seen(image):
                return None
            view = View(image)
            return (view, image) if self._light_is_seen(view, image) and _box_is_seen(view, image) else None

        return self._wait_for(look, f"show the light and the box; rviz -d {CONFIG} may say why")

    def _drag(self, step: Step) -> None:
        """Publish the events of a step as RViz does, and wait until the box has moved."""
        for event in step.events:
            self._drags.publish(messages.drag(self._arm.robot, step.T_base_box, step.handle, event))
        world = self._arm.player.demo.world
        where = f"get the box to {step.T_base_box[:3, 3]} m"
        self._wait_for(lambda: np.allclose(world.pose(BOX_NAME), step.T_base_box) or None, where)

    def _drawn(self, view: View, before: Image) -> Image:
        """The screen, once two equal screenshots show the light, after a change or _DRAWS_WITHIN_S."""
        start, changed, last = time.monotonic(), False, before

        def look() -> Image | None:
            nonlocal changed, last
            image = self._screen.pixels()
            same = np.array_equal(image, last)
            waited = time.monotonic() - start > _DRAWS_WITHIN_S
            drawn = same and (changed or waited) and self._light_is_seen(view, image)
            changed, last = changed or not same, image
            return image if drawn else None

        return self._wait_for(look, "draw the light of this moment")

    def _wait_for(self, look: Callable[[], _T | None], what: str) -> _T:
        """Call ``look`` until it returns a value, and return that."""
        end = time.monotonic() + _APPEARS_WITHIN_S
        while time.monotonic() < end:
            self._pause()
            if (found := look()) is not None:
                return found
        raise RVizError(f"RViz did not {what} (within {_APPEARS_WITHIN_S:g} s)")

    def _pause(self) -> None:
        """Wait a moment, and send the arm again, since RViz removes old markers."""
        self._keep()
        self._arm.player.advance(0.0)
        time.sleep(_LOOK_S)

    def _light_is_seen(self, view: View, image: Image) -> bool:
        """Whether a picture of the screen shows the light in the color of the last report, red or green."""
        red, green, blue = np.moveaxis(view.around(image, LIGHT_POSITION, 12).astype(int), -1, 0)
        is_red = light_color(self._arm.player.report) == RED
        clear = red - np.maximum(green, blue) if is_red else green - np.maximum(red, blue)
        return int(np.count_nonzero(clear > 60)) > _LIGHT_PIXELS


def _box_is_seen(view: View, image: Image) -> bool:
    """Whether a picture of the screen shows the box, brown, at its start."""
    red, _, blue = np.moveaxis(view.around(image, BOX_START, 25).astype(int), -1, 0)
    return int(np.count_nonzero(red - blue > 60)) > _BOX_PIXELS
