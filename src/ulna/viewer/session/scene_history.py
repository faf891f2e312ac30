"""Undoes and redoes the steps of a person on the page.

A step is a pair of functions: one undoes it, one redoes it.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.grids import Obstacle
from ulna.collision.world import World, exchange

_MAX_STEPS = 100


class Entry(NamedTuple):
    """An object of a world.

    Attributes:
        shape: Its shape.
        T: T_base_object, shape (4, 4).
        touch_links: The links that may touch it.
        speed: Its maximum speed [m/s], as ``World.add`` takes it; None if it moves by the program alone.
    """

    shape: Obstacle
    T: NDArray[np.float64]
    touch_links: frozenset[str]
    speed: float | None


Scene = dict[str, Entry]
Act = Callable[[], tuple[str, ...]]  # returns the names of the objects that it added or changed


def scene_of(world: World) -> Scene:
    """The objects of a world by name."""
    still = world.snapshot()
    return {name: Entry(shape, T, still.touch_links(name), still.speed(name)) for name, shape, T in still.items()}


def world_of(scene: Scene) -> World:
    """A world with the objects of a scene."""
    world = World()
    for name, (shape, T, touch_links, speed) in scene.items():
        world.add(name, shape, T, touch_links=touch_links, speed=speed)
    return world


class SceneHistory:
    """The undo and redo history of one world. Changes made by the program are no steps.

    The first ``_n_done`` steps are done, the others are undone. Every step is noted before it starts. After an interrupt
    (Ctrl-C) the next call completes it.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._steps: list[tuple[Act, Act]] = []
        self._n_done = 0
        self._scene_before: Scene | None = None  # the scene before the present step
        self._pending_act: tuple[int, Act] | None = None  # the present act, and the number of steps that are done after it

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        self._complete()
        return self._n_done > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to redo."""
        self._complete()
        return self._n_done < len(self._steps)

    @contextmanager
    def step(self) -> Iterator[None]:
        """A context whose changes of the world are one step, even if it ends with an exception."""
        self._complete()
        self._scene_before = scene_of(self._world)
        try:
            yield
        finally:
            self._complete()

    def add(self, before: Scene, after: Scene) -> None:
        """Add a step from one scene to another, unless they are equal. This drops the steps that can be redone."""
        self._complete()
        self._add(before, after)

    def add_acts(self, undo: Act, redo: Act) -> None:
        """Add a completed step as its two functions. Each may be called twice."""
        self._complete()
        self._add_acts(undo, redo)

    def undo(self) -> tuple[str, ...]:
        """Undo the last step. Returns the names of the objects that this added or changed."""
        if not self.can_undo:
            return ()
        n = self._n_done - 1
        self._pending_act = n, self._steps[n][0]
        return self._complete()

    def redo(self) -> tuple[str, ...]:
        """Redo the step that was undone last. Returns the names of the objects that this added or changed."""
        if not self.can_redo:
            return ()
        n = self._n_done
        self._pending_act = n + 1, self._steps[n][1]
        return self._complete()

    def _complete(self) -> tuple[str, ...]:
        """Complete an interrupted act, and close a step whose changes were made."""
        names: tuple[str, ...] = ()
        if self._scene_before is not None:
            self._add(self._scene_before, scene_of(self._world))
        if self._pending_act is not None:
            n, act = self._pending_act
            names = act()
            self._n_done, self._pending_act = n, None
        return names

    def _add(self, before: Scene, after: Scene) -> None:
        changed = [name for name in before | after if not _equal(before.get(name), after.get(name))]
        if changed:
            old, new = ({name: scene[name] for name in changed if name in scene} for scene in (before, after))
            self._add_acts(partial(self._apply, new, old), partial(self._apply, old, new))
        else:
            self._scene_before = None

    def _add_acts(self, undo: Act, redo: Act) -> None:
        steps = [*self._steps[: self._n_done], (undo, redo)][-_MAX_STEPS:]
        n = len(steps)
        self._steps, self._n_done, self._scene_before = steps, n, None

    def _apply(self, before: Scene, after: Scene) -> tuple[str, ...]:
        exchange(self._world, before.keys() - after.keys(), world_of(after))
        return tuple(after)


def _equal(one: Entry | None, other: Entry | None) -> bool:
    if one is None or other is None:
        return one is other
    same = (one.touch_links, one.speed) == (other.touch_links, other.speed)
    return same and one.shape == other.shape and np.array_equal(one.T, other.T)
