"""Computes the mouse pointer's path in the video of RViz: it drags the box by its arrows. Used by ``rviz_video``."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GRIP = 0.17  # [m] from the middle of the box along an arrow: where the pointer presses
_AXES = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0)}
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drag:
    """A drag of the box along an axis, and a pause.

    Attributes:
        axis: "x" or "z".
        way: Its length [m].
        lasts, rests: Duration of the drag and of the pause, as parts of the video.
    """

    axis: str
    way: float
    lasts: float
    rests: float


# Up into the path of the hand, under the hand and back, down, to the base and back. Nothing hides the arrows used.
DRAGS = (
    Drag("z", 0.26, 0.12, 0.10),
    Drag("x", -0.14, 0.08, 0.12),
    Drag("x", 0.14, 0.08, 0.02),
    Drag("z", -0.26, 0.12, 0.06),
    Drag("x", -0.38, 0.12, 0.04),
    Drag("x", 0.38, 0.12, 0.02),
)


@dataclass(frozen=True)
class Step:
    """The mouse in one frame.

    Attributes:
        place: Where it is [pixel x, y].
        press: True if its button is pressed, False if released, else None.
        box: Where the box is to be then [m], shape (3,).
    """

    place: Array
    box: Array
    press: bool | None = None


def steps(n_frames: int, box: Callable[[], Array], project: Callable[[Array], Array]) -> Iterator[Step | None]:
    """A step for each frame; None where the mouse does nothing.

    Args:
        n_frames: How many frames there are, at least three for each drag.
        box: Returns the position of the box [m], shape (3,); called at the start of each drag.
        project: Returns the place [pixel x, y] of a point in the base frame [m].
    """
    done, ends = 0, 0.0
    for drag in DRAGS:
        axis, start = np.array(_AXES[drag.axis]), box()
        n = max(round(drag.lasts * n_frames), 3) - 2
        yield Step(project(start + GRIP * axis), start)  # RViz must see the pointer over the arrow before the button goes down
        yield Step(project(start + GRIP * axis), start, press=True)
        for k in range(1, n + 1):
            there = start + drag.way * k / n * axis
            yield Step(project(there + GRIP * axis), there, press=False if k == n else None)
        ends += (drag.lasts + drag.rests) * n_frames
        done += n + 2
        while done < round(ends):
            done += 1
            yield None
    for _ in range(done, n_frames):
        yield None
