"""Records the demo in RViz on a virtual screen as a video.

The video is made frame by frame: the arm advances by a tenth of a second, the box by a step, and the frame is taken when RViz has
drawn both. So the video has the right speed, however slowly this machine draws.
"""

# pyright: reportMissingImports=false

import os
import shutil
from collections.abc import Callable
from contextlib import ExitStack
from importlib.resources import as_file
from pathlib import Path
from typing import cast

from ulna.demo.ros.children import Children
from ulna.demo.ros.drags import DRAGS
from ulna.demo.ros.ros1 import node
from ulna.demo.ros.ros1_demo import Beside, begin_ended_again, have_master
from ulna.demo.ros.rviz_view import CONFIG
from ulna.demo.ros.screencast import Screencast
from ulna.demo.ros.virtual_screen import virtual_screen
from ulna.demo.scenario import RATE_HZ, Demo
from ulna.errors import InputError, MissingROSError
from ulna.viewer.compiler import Compiler
from ulna.viewer.film.film import Film, write_film

# The programs, and Debian's packages that have them.
_NEEDED = {"rosmaster": "python3-rosmaster", "rviz": "rviz", "Xvfb": "xvfb", "xdotool": "xdotool"}
LEAST_SECONDS = 3.0  # a few pictures for each drag


def record_rviz(path: Path, seconds: float, compiler: Compiler, tell: Callable[[int], object] = lambda _: None) -> None:
    """Record the demo in RViz as an .mp4 of ten pictures a second, and end everything that was started.

    Args:
        path: The file.
        seconds: The length of the video [s].
        compiler: Compiles what the demo needs.
        tell: Called with the number of pictures done so far.

    Raises:
        MissingROSError: A program is not on this machine.
        RVizError: RViz does not show the scene.
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

        def keep() -> None:
            if ended():
                raise KeyboardInterrupt
            begin_ended_again(master, beside)

        pictures = Screencast(screen, demo, compiler, round(seconds * RATE_HZ), keep, tell)
        write_film(path, cast("Film", pictures))  # an .mp4 takes its frames, size and rate


def _refuse_missing() -> None:
    missing = [program for program in _NEEDED if shutil.which(program) is None]
    if missing:
        packages = " ".join(_NEEDED[program] for program in missing)
        raise MissingROSError(f"not on this machine: {', '.join(missing)}; on Debian: apt-get install {packages}")
