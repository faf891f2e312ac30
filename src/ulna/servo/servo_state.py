"""Holds the state of a servo after a tick, and adapts it to a world that has changed."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ulna.collision.objects import Moving, Objects
from ulna.engine.records import Records, copied
from ulna.kernels.servo.servo_records import JointState, MovingObject, StopCounters

Array = NDArray[np.float64]
ROUNDING = 1e-12  # [m, rad]: rounding of this size never counts as a fast object, or as an arm off its command


class ServoState(NamedTuple):
    """State of a servo after a tick. It never changes: each tick writes to arrays of its own.

    Attributes:
        joints: Last command and its braking trajectory, shape (n_dof,).
        counters: Counters of the servo, shape (1,).
        moving: Objects that may move by themselves, shape (n,).
        wider: Distance beyond the clearance that each object needs [m]; every tick overwrites it.
        objects: Objects of the world in which the braking trajectory was certified; None before the first tick.
        reported: The objects of ``moving`` with their last reported poses.
        too_fast: Name of an object that moved faster than its stated speed before this tick; None without one.
        ticks: Number of ticks since the last start; None before the first start.
    """

    joints: Records[JointState]
    counters: Records[StopCounters]
    moving: Records[MovingObject]
    wider: Array
    objects: Objects | None
    reported: tuple[Moving, ...]
    too_fast: str | None
    ticks: int | None

    @classmethod
    def unstarted(cls, n_dof: int) -> Self:
        """Make the state before the first start."""
        return cls(JointState.records(n_dof), StopCounters.records(), MovingObject.records(0), np.zeros(2), None, (), None, None)

    def before_tick(self, objects: Objects, ticks: int) -> "ServoState":
        """Copy the state for tick number ``ticks`` to write to, with the current objects of the world."""
        joints, counters = copied(self.joints), copied(self.counters)
        if objects is self.objects:
            moving = copied(self.moving) if self.reported else self.moving
            return ServoState(joints, counters, moving, self.wider, objects, self.reported, None, ticks)
        moving, too_fast = self._moved(objects)
        is_moving = self.objects is not None and counters[0].done < counters[0].ticks
        if not is_moving or too_fast is not None or self.objects is None or objects.n_changes != self.objects.n_changes:
            counters[0].certified = False
        wider = np.zeros(len(objects.layout.names) + 2)
        return ServoState(joints, counters, moving, wider, objects, objects.moving, too_fast, ticks)

    def _moved(self, objects: Objects) -> tuple[Records[MovingObject], str | None]:
        """Make ``moving`` for a changed world, and find an object that moved faster than its stated speed; None without one."""
        before = {one.name: (one, row.age) for one, row in zip(self.reported, self.moving, strict=True)}
        moving, too_fast = MovingObject.records(len(objects.moving)), None
        for one, row in zip(objects.moving, moving, strict=True):
            row.number, row.speed, row.in_tree = one.number, one.speed, one.in_tree
            known, age = before.get(one.name, (one, 0.0))
            if known.n_updates == one.n_updates:
                row.age = age
            elif one.max_displacement(known.pose) > known.speed * age + ROUNDING:
                too_fast = one.name
        return moving, too_fast
