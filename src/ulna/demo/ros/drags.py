"""Computes how the box is dragged in the video of RViz: the pointer, the events and the box."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.demo.scenario import BOX_START

GRIP = 0.17  # [m] from the middle of the box along an arrow: where the pointer holds it
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
    """The drag in one frame.

    Attributes:
        pointer: The point under the pointer, on an arrow of the box, in the base frame [m], shape (3,).
        box: Where the box is [m], shape (3,).
        axis: That of the arrow, "x" or "z".
        events: What RViz publishes of it, by the names in ``InteractiveMarkerFeedback``, in order.
    """

    pointer: Array
    box: Array
    axis: str
    events: tuple[str, ...]


def steps(n_frames: int) -> Iterator[Step | None]:
    """A step for each frame, at least three for each drag; None where the pointer does nothing."""
    box, done, ends = np.array(BOX_START), 0, 0.0
    for drag in DRAGS:
        axis, start = np.array(_AXES[drag.axis]), box
        n = max(round(drag.lasts * n_frames), 3) - 2
        yield Step(start + GRIP * axis, start, drag.axis, ())
        yield Step(start + GRIP * axis, start, drag.axis, ("MOUSE_DOWN",))
        for k in range(1, n + 1):
            box = start + drag.way * k / n * axis
            yield Step(box + GRIP * axis, box, drag.axis, ("POSE_UPDATE", "MOUSE_UP") if k == n else ("POSE_UPDATE",))
        ends += (drag.lasts + drag.rests) * n_frames
        done += n + 2
        while done < round(ends):
            done += 1
            yield None
    for _ in range(done, n_frames):
        yield None
