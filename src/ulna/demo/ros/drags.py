"""Computes the drags in the video of RViz: the pointer, the events and the pose of the box."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.demo.scenario import BOX_START
from ulna.description.pose import pose

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
# Points where the pointer holds a handle, in the axes of the box [m]: on the arrow, and on the part of the ring that faces the
# camera as the box is turned. RViz draws both at these distances for the size of the handles in ``messages``.
_ON_ARROW, _ON_RING, _RING_ANGLE = 0.17, 0.1265, 0.39
GRIPS = {
    **{f"move_{axis}": tuple(_ON_ARROW * np.array(direction)) for axis, direction in _AXES.items()},
    "rotate_z": (_ON_RING * np.cos(_RING_ANGLE), _ON_RING * np.sin(_RING_ANGLE), 0.0),
}
_TURN = float(np.arctan2(4.0, 3.0))  # [rad], turn of the box: afterwards its x arrow points along (0.6, 0.8, 0)
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drag:
    """A drag of the box by a handle, and a pause.

    Attributes:
        handle: The name of an arrow or a ring: "move_x", "rotate_z".
        way: The distance along the handle's axis, or the angle about it [m or rad].
        lasts, rests: Duration of the drag and of the pause, as fractions of the video.
    """

    handle: str
    way: float
    lasts: float
    rests: float = 0.0

    def moved(self, part: float) -> Array:
        """The pose of the box after a fraction of the drag, relative to its start, shape (4, 4)."""
        along = part * self.way * np.array(_AXES[self.handle[-1]])
        return pose(rotvec=along) if self.handle.startswith("rotate") else pose(along)


# To the hand, where the box is turned, to the forearm, the elbow, the hand again, the base, and back. Nothing hides the handles
# in use. Places of contact are deep enough to touch the arm at any point of its trajectory; the others are far enough to be free.
DRAGS = (
    Drag("move_z", 0.35, 0.045),
    Drag("move_x", -0.16, 0.03, 0.015),
    Drag("rotate_z", _TURN, 0.05, 0.01),
    Drag("move_x", 0.30, 0.035),
    Drag("rotate_z", -_TURN, 0.03),
    Drag("move_z", 0.12, 0.02),
    Drag("move_x", -0.42, 0.045),
    Drag("move_y", -0.16, 0.035, 0.06),
    Drag("move_y", 0.24, 0.035, 0.015),
    Drag("move_x", -0.20, 0.03),
    Drag("move_y", -0.30, 0.05, 0.055),
    Drag("move_y", 0.30, 0.05),
    Drag("move_x", 0.44, 0.045),
    Drag("move_y", -0.32, 0.05, 0.045),
    Drag("move_x", 0.16, 0.03),
    Drag("move_z", -0.47, 0.055),
    Drag("move_x", -0.40, 0.05, 0.045),
    Drag("move_x", 0.40, 0.05),
)


@dataclass(frozen=True)
class Step:
    """The drag in one frame.

    Attributes:
        pointer: The point under the pointer, on a handle of the box, in the base frame [m], shape (3,).
        T_base_box: The pose of the box, shape (4, 4).
        handle: The name of the arrow or ring, "move_x".
        events: The events that RViz publishes, by their names in ``InteractiveMarkerFeedback``, in order.
    """

    pointer: Array
    T_base_box: Array
    handle: str
    events: tuple[str, ...]


def steps(n_frames: int) -> Iterator[Step | None]:
    """A step for each frame, at least three for each drag; None for frames without a drag."""
    place, done, ends = pose(BOX_START), 0, 0.0
    for drag in DRAGS:
        start, n = place, max(round(drag.lasts * n_frames), 3) - 2
        for events in ((), ("MOUSE_DOWN",)):
            yield _step(drag, start, events)
        for k in range(1, n + 1):
            place = start @ drag.moved(k / n)
            yield _step(drag, place, ("POSE_UPDATE", "MOUSE_UP") if k == n else ("POSE_UPDATE",))
        ends += (drag.lasts + drag.rests) * n_frames
        done += n + 2
        while done < round(ends):
            done += 1
            yield None
    for _ in range(done, n_frames):
        yield None


def _step(drag: Drag, T_base_box: Array, events: tuple[str, ...]) -> Step:
    """A step of a drag, with the pointer on its handle."""
    return Step(T_base_box[:3, 3] + T_base_box[:3, :3] @ GRIPS[drag.handle], T_base_box, drag.handle, events)
