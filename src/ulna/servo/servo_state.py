"""Holds what a servo knows after a tick, and takes over a world that has changed."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ulna.collision.objects import Moving, Objects
from ulna.engine.records import Records, copied
from ulna.kernels.servo.servo_records import JointState, MovingObject, StopCounters

Array = NDArray[np.float64]
ROUNDING = 1e-12  # [m, rad]: no object moved too fast by less, of which ``MOVED`` allows many; nor is the arm off its command


class ServoState(NamedTuple):
    """The state of a servo after a tick. A tick writes to arrays of its own, so nothing of it changes later.

    Attributes:
        joints: The last command and its stop, shape (n_dof,).
        counters: What is counted besides, shape (1,).
        moving: The objects that may move by themselves, shape (n,).
        wider: By how much each object has to be farther away [m]; every tick writes it anew.
        objects: Those of the world in which the stop was certified; None before the first tick.
        stated: The objects of ``moving``, as they were stated last.
        too_fast: An object that moved faster than its stated speed before this tick.
        ticks: Since the last start; None before the first.
    """

    joints: Records[JointState]
    counters: Records[StopCounters]
    moving: Records[MovingObject]
    wider: Array
    objects: Objects | None
    stated: tuple[Moving, ...]
    too_fast: str | None
    ticks: int | None

    @classmethod
    def unstarted(cls, n_dof: int) -> Self:
        """The state before the first start."""
        return cls(JointState.records(n_dof), StopCounters.records(), MovingObject.records(0), np.zeros(2), None, (), None, None)

    def before_tick(self, objects: Objects, ticks: int) -> "ServoState":
        """A copy for a tick to write to, in the world as it is now; ``ticks`` is its number."""
        joints, counters = copied(self.joints), copied(self.counters)
        if objects is self.objects:
            moving = copied(self.moving) if self.stated else self.moving
            return ServoState(joints, counters, moving, self.wider, objects, self.stated, None, ticks)
        moving, too_fast = self._moved(objects)
        is_moving = self.objects is not None and counters[0].done < counters[0].ticks
        if not is_moving or too_fast is not None or self.objects is None or objects.n_changes != self.objects.n_changes:
            counters[0].certified = False
        wider = np.zeros(len(objects.layout.names) + 2)
        return ServoState(joints, counters, moving, wider, objects, objects.moving, too_fast, ticks)

    def _moved(self, objects: Objects) -> tuple[Records[MovingObject], str | None]:
        """``moving`` of another world, and which of its objects moved faster than was stated, if any."""
        before = {one.name: (one, row.age) for one, row in zip(self.stated, self.moving, strict=True)}
        moving, too_fast = MovingObject.records(len(objects.moving)), None
        for one, row in zip(objects.moving, moving, strict=True):
            row.number, row.speed, row.in_tree = one.number, one.speed, one.in_tree
            known, age = before.get(one.name, (one, 0.0))
            if known.stated == one.stated:
                row.age = age
            elif one.way_from(known.pose) > known.speed * age + ROUNDING:
                too_fast = one.name
        return moving, too_fast
