"""Says where the pointer is at each moment of the video of RViz: it drags the box by its arrows. Used by ``rviz_video``."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GRIP = 0.17  # m from the middle of the box, along an arrow: where it is taken
_AXES = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, 1.0)}
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drag:
    """The box is dragged along an axis, and then let alone.

    Attributes:
        axis: "x" or "z".
        way: How far [m].
        lasts, rests: For which shares of the video.
    """

    axis: str
    way: float
    lasts: float
    rests: float


# Up to where the hand passes in each cycle, under the hand and back, down, to the base and back: along arrows that nothing hides.
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
    """What the mouse does in one frame: where it moves to [pixel x, y], and if its button goes down, up or neither (None)."""

    place: Array
    press: bool | None = None


def steps(n_frames: int, box: Callable[[], Array], project: Callable[[Array], Array]) -> Iterator[Step | None]:
    """A step for each frame; None where nothing is done.

    Args:
        n_frames: How many frames there are, at least three for each drag.
        box: Where the box is now [m], shape (3,): asked when a drag begins.
        project: Where a point of the base frame [m] is seen [pixel x, y].
    """
    done, ends = 0, 0.0
    for drag in DRAGS:
        axis, start = np.array(_AXES[drag.axis]), box()
        n = max(round(drag.lasts * n_frames), 3) - 2
        yield Step(project(start + GRIP * axis))  # RViz must see the pointer over the arrow before the button goes down
        yield Step(project(start + GRIP * axis), press=True)
        for k in range(1, n + 1):
            yield Step(project(start + (GRIP + drag.way * k / n) * axis), press=False if k == n else None)
        ends += (drag.lasts + drag.rests) * n_frames
        done += n + 2
        while done < round(ends):
            done += 1
            yield None
    for _ in range(done, n_frames):
        yield None
