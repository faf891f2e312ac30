"""Records RViz on a virtual screen while the mouse drags the box by its arrows. Used by ``ulna ros1 record``.

The video is made frame by frame: the arm advances by a tenth of a second, the pointer by a step, and the frame is taken when RViz
has drawn both, with the light of that moment. So the video has the right speed, however slowly this machine draws.
"""

# pyright: reportMissingImports=false

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib.resources import as_file
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ulna.demo.ros.children import Children
from ulna.demo.ros.drags import DRAGS, steps
from ulna.demo.ros.ros1 import ArmAndLight, MovableBox, node
from ulna.demo.ros.ros1_demo import Beside, have_master
from ulna.demo.ros.rviz_view import CONFIG, View, scene_is_seen
from ulna.demo.ros.virtual_screen import SIZE, VirtualScreen, virtual_screen
from ulna.demo.scenario import BOX_NAME, BOX_START, LIGHT_POSITION, RATE_HZ, Demo, light_color
from ulna.errors import InputError, MissingROSError, UlnaError
from ulna.viewer.film.files import write_film
from ulna.viewer.film.film import Film
from ulna.viewer.palette import RED

# The programs, and Debian's packages that have them.
_NEEDED = {"rosmaster": "python3-rosmaster", "rviz": "rviz", "Xvfb": "xvfb", "xdotool": "xdotool"}
_APPEARS_WITHIN_S, _DRAWS_WITHIN_S = 120.0, 2.0
_HOLDS_WITHIN_S = 5.0  # longer than RViz stands still: a press that it takes later would be mistaken for the next
_LOOK_S = 0.05  # interval between screenshots
LEAST_SECONDS = 3.0  # a few pictures for each drag
_GRIPS = 10  # presses on an arrow, or moves to its end, before the recording fails
_LIGHT_PIXELS = 200  # of its colour, if it is seen
MISSED = 0.05  # [m] the largest distance from its start at which the box may end
Tell = Callable[[int], object]


class RVizError(UlnaError, RuntimeError):
    """RViz does not show the scene, or a drag has failed."""


def record_rviz(path: Path, seconds: float, tell: Tell = lambda _: None) -> None:
    """Record the demo in RViz as an .mp4 of ten pictures a second, and end everything that was started.

    Args:
        path: The file.
        seconds: The length of the video [s].
        tell: Called with the number of pictures done so far.

    Raises:
        MissingROSError: A program is not on this machine.
        RVizError: RViz does not show the scene, or the pointer has missed the box.
        InputError: The path does not end in .mp4, or the video is too short for the drags.
        FileError: The file cannot be written.
    """
    if path.suffix.lower() != ".mp4":
        raise InputError("path", f"{path.name!r}; RViz is recorded as an .mp4")
    if not LEAST_SECONDS <= seconds <= 3600.0:
        raise InputError(
            "seconds", f"{seconds:g}; {LEAST_SECONDS:g} to 3600 s are expected: the box is dragged {len(DRAGS)} times"
        )
    _refuse_missing()
    demo = Demo()
    with ExitStack() as stack:
        screen = stack.enter_context(virtual_screen())
        os.environ["DISPLAY"] = screen.name
        master = stack.enter_context(Children())
        have_master(master)
        ended = stack.enter_context(node("ulna_video"))
        beside = stack.enter_context(Beside(demo, str(stack.enter_context(as_file(CONFIG)))))
        beside.meet_master()
        pictures = Screencast(screen, ArmAndLight(demo), MovableBox(demo.robot), round(seconds * RATE_HZ), ended, tell)
        write_film(path, cast("Film", pictures))  # an .mp4 takes its frames, size and rate


class Screencast:
    """The frames of RViz in the interface that ``write_film`` needs.

    Attributes:
        size, rate: Width and height [pixels]; pictures a second.
    """

    size, rate = SIZE, round(RATE_HZ)

    def __init__(
        self, screen: VirtualScreen, arm: ArmAndLight, box: MovableBox, n: int, ended: Callable[[], bool], tell: Tell
    ) -> None:
        self._screen, self._arm, self._box, self._n, self._ended, self._tell = screen, arm, box, n, ended, tell

    def __len__(self) -> int:
        return self._n

    def frames(self) -> Iterator[NDArray[np.uint8]]:
        """Play the demo, drag the box, and yield each frame, shape (height, width, 3).

        Raises:
            KeyboardInterrupt: The node was ended meanwhile.
            RVizError: The box did not end at its start, so the pointer has missed an arrow of it.
        """
        view, before = self._wait_for_scene()
        for k, step in enumerate(steps(self._n, self._place_of_box, view.project)):
            self._arm.player.advance(1.0 / RATE_HZ)
            if step is not None:
                self._screen.move_mouse(step.place)
            before = self._drawn(view, before)
            if step is not None and step.press is True:
                self._grip(step.place)
            elif step is not None and step.press is False:
                self._finish(step.place, step.box)
            self._tell(k + 1)
            yield before
        if np.abs(self._place_of_box() - BOX_START).max() > MISSED:
            raise RVizError(f"the box ends at {self._place_of_box().round(3)} m: the pointer has missed an arrow of it")

    def _place_of_box(self) -> NDArray[np.float64]:
        """Where the box was dragged to, by the messages of RViz [m], shape (3,)."""
        return self._arm.player.demo.world.pose(BOX_NAME)[:3, 3]

    def _wait_for_scene(self) -> tuple[View, NDArray[np.uint8]]:
        """The view and the pixels of RViz's window, once it shows the light."""
        end = time.monotonic() + _APPEARS_WITHIN_S
        while time.monotonic() < end and not self._ended():
            self._arm.player.advance(0.0)
            image = self._screen.pixels()
            if scene_is_seen(image):
                view = View(image)
                if self._light_is_seen(view, image):
                    return view, image
            time.sleep(1.0 / RATE_HZ)
        raise RVizError(f"RViz did not show the light within {_APPEARS_WITHIN_S:g} s; rviz -d {CONFIG} may say why")

    def _drawn(self, view: View, before: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The screen, once two screenshots are equal that show the light, after a change or _DRAWS_WITHIN_S."""
        start, changed, last = time.monotonic(), False, before
        while (waited := time.monotonic() - start) < _APPEARS_WITHIN_S:
            self._pause()
            image = self._screen.pixels()
            same = np.array_equal(image, last)
            if same and (changed or waited > _DRAWS_WITHIN_S) and self._light_is_seen(view, image):
                return image
            changed, last = changed or not same, image
        raise RVizError(f"RViz did not draw the light of this moment within {_APPEARS_WITHIN_S:g} s")

    def _grip(self, place: NDArray[np.float64]) -> None:
        """Press the button over an arrow of the box, until RViz says that it is held.

        RViz looks what lies under the pointer only when it moves, and once a frame: while it draws slowly, a press may be taken
        for the view's. That does nothing if the pointer has not moved meanwhile.
        """
        for _ in range(_GRIPS):
            self._screen.press(down=True)
            if self._wait_until(lambda: self._box.is_held, _HOLDS_WITHIN_S):
                return
            self._screen.press(down=False)
            self._nudge(place)
        raise RVizError(f"RViz does not hold the box after {_GRIPS} presses on an arrow of it at pixel {place.round()}")

    def _nudge(self, place: NDArray[np.float64]) -> None:
        """Move the pointer by a pixel and back, so that RViz looks at it again."""
        for aside in (1.0, 0.0):
            self._screen.move_mouse(place + aside)
            time.sleep(1.0 / RATE_HZ)

    def _finish(self, place: NDArray[np.float64], box: NDArray[np.float64]) -> None:
        """Release the button once RViz has the box where it is to be: moves just before a release are lost if it stands still."""

        def is_there() -> bool:
            return float(np.abs(self._place_of_box() - box).max()) < MISSED

        for _ in range(_GRIPS):
            if self._wait_until(is_there, _DRAWS_WITHIN_S):
                break
            self._nudge(place)
        else:
            raise RVizError(f"the box is at {self._place_of_box().round(3)} m, and the pointer has dragged it to {box.round(3)}")
        self._screen.press(down=False)
        self._wait_until(lambda: not self._box.is_held, _APPEARS_WITHIN_S)

    def _wait_until(self, is_so: Callable[[], bool], limit: float) -> bool:
        """Wait until it is so, at most for a limit [s]; return whether it is."""
        end = time.monotonic() + limit
        while not is_so() and time.monotonic() < end:
            self._pause()
        return is_so()

    def _pause(self) -> None:
        """Send the arm again, since RViz removes markers that are old, and wait a moment."""
        if self._ended():
            raise KeyboardInterrupt
        self._arm.player.advance(0.0)
        time.sleep(_LOOK_S)

    def _light_is_seen(self, view: View, image: NDArray[np.uint8]) -> bool:
        """Whether a picture of the screen shows the light, red or green as the last report has it."""
        red, green, blue = np.moveaxis(view.around(image, LIGHT_POSITION, 12).astype(int), -1, 0)
        is_red = light_color(self._arm.player.report) == RED
        clear = red - np.maximum(green, blue) if is_red else green - np.maximum(red, blue)
        return int(np.count_nonzero(clear > 60)) > _LIGHT_PIXELS


def _refuse_missing() -> None:
    missing = [program for program in _NEEDED if shutil.which(program) is None]
    if missing:
        packages = " ".join(_NEEDED[program] for program in missing)
        raise MissingROSError(f"not on this machine: {', '.join(missing)}; on Debian: apt-get install {packages}")
