"""Holds what a servo knows after a tick, and takes over a world that has changed."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ulna.collision.objects import Moving, Objects
from ulna.kernels.servo import servo_layout as layout

Array = NDArray[np.float64]
ROUNDING = 1e-12  # [m, rad]: no object moved too fast by less, of which ``MOVED`` allows many; nor is the arm off its command


class ServoState(NamedTuple):
    """The state of a servo after a tick. A tick writes to arrays of its own, so nothing of it changes later.

    Attributes:
        motion: The last command and its stop (``servo_layout``), shape (N_STATE, n_dof).
        counters: Whole numbers of the same, shape (N_COUNTERS,).
        moving: The objects that may move by themselves, shape (n, MOVING_WIDTH).
        wider: By how much each object has to be farther away [m]; every tick writes it anew.
        objects: Those of the world in which the stop was certified; None before the first tick.
        stated: The objects of ``moving``, as they were stated last.
        too_fast: An object that moved faster than its stated speed before this tick.
        ticks: Since the last start; None before the first.
    """

    motion: Array
    counters: NDArray[np.int64]
    moving: Array
    wider: Array
    objects: Objects | None
    stated: tuple[Moving, ...]
    too_fast: str | None
    ticks: int | None

    @classmethod
    def unstarted(cls, n_dof: int) -> Self:
        """The state before the first start."""
        motion, counters = np.zeros((layout.N_STATE, n_dof)), np.zeros(layout.N_COUNTERS, dtype=np.int64)
        none = np.empty((0, layout.MOVING_WIDTH))
        return cls(motion, counters, none, np.zeros(2), None, (), None, None)

    def before_tick(self, objects: Objects, ticks: int) -> "ServoState":
        """A copy for a tick to write to, in the world as it is now; ``ticks`` is its number."""
        motion, counters = self.motion.copy(), self.counters.copy()
        if objects is self.objects:
            moving = self.moving.copy() if self.stated else self.moving
            return ServoState(motion, counters, moving, self.wider, objects, self.stated, None, ticks)
        moving, too_fast = self._moved(objects)
        is_moving = self.objects is not None and counters[layout.DONE] < counters[layout.TICKS]
        if not is_moving or too_fast is not None or self.objects is None or objects.n_changes != self.objects.n_changes:
            counters[layout.CERTIFIED] = 0
        wider = np.zeros(len(objects.layout.names) + 2)
        return ServoState(motion, counters, moving, wider, objects, objects.moving, too_fast, ticks)

    def _moved(self, objects: Objects) -> tuple[Array, str | None]:
        """``moving`` of another world, and which of its objects moved faster than was stated, if any."""
        before = {one.name: (one, row[layout.AGO]) for one, row in zip(self.stated, self.moving, strict=True)}
        moving, too_fast = np.zeros((len(objects.moving), layout.MOVING_WIDTH)), None
        for one, row in zip(objects.moving, moving, strict=True):
            row[:] = one.number, one.speed, 0.0, one.in_tree
            known, ago = before.get(one.name, (one, 0.0))
            if known.stated == one.stated:
                row[layout.AGO] = ago
            elif one.way_from(known.pose) > known.speed * ago + ROUNDING:
                too_fast = one.name
        return moving, too_fast
