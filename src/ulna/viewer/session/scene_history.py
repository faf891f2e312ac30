"""Undoes and redoes what a person does: each step is two acts. Those of the obstacles put back what a step has changed."""

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
    """An object of a world: its shape, T_base_object, shape (4, 4), and the links that may touch it, and its speed [m/s]."""

    shape: Obstacle
    T: NDArray[np.float64]
    touch_links: frozenset[str]
    speed: float | None


Scene = dict[str, Entry]
Act = Callable[[], tuple[str, ...]]  # returns the names of the objects that it gave back or changed


def scene_of(world: World) -> Scene:
    """The objects of a world by name."""
    still = world.snapshot()
    return {name: Entry(shape, T, still.touch_links(name), still.speed(name)) for name, shape, T in still.items()}


def world_of(scene: Scene) -> World:
    """A world of such objects."""
    world = World()
    for name, (shape, T, touch_links, speed) in scene.items():
        world.add(name, shape, T, touch_links=touch_links, speed=speed)
    return world


class SceneHistory:
    """The steps of one world, of which the first ``_n_done`` are done. What the program changes is no step.

    A step that is interrupted, as by Ctrl-C, is noted before, so that the next call goes on with it: then it is done in whole.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._steps: list[tuple[Act, Act]] = []
        self._n_done = 0
        self._open: Scene | None = None  # as it was before a step that is being done
        self._doing: tuple[int, Act] | None = None  # an act that is being done, and how many steps are done after it

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        self._go_on()
        return self._n_done > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to do again."""
        self._go_on()
        return self._n_done < len(self._steps)

    @contextmanager
    def step(self) -> Iterator[None]:
        """A context: what is changed in it is one step, also if it ends with an exception."""
        self._go_on()
        self._open = scene_of(self._world)
        try:
            yield
        finally:
            self._go_on()

    def add(self, before: Scene, after: Scene) -> None:
        """Add a step from one scene to another, unless they are equal. Steps that were undone cannot be done again then."""
        self._go_on()
        self._add(before, after)

    def add_acts(self, undo: Act, redo: Act) -> None:
        """Add a step that was done, by what undoes it and what does it again. Each may be called twice."""
        self._go_on()
        self._add_acts(undo, redo)

    def undo(self) -> tuple[str, ...]:
        """Undo the last step. Returns the names of the objects that it gave back or changed."""
        if not self.can_undo:
            return ()
        n = self._n_done - 1
        self._doing = n, self._steps[n][0]
        return self._go_on()

    def redo(self) -> tuple[str, ...]:
        """Do the step again that was undone last. Returns the names of the objects that it added or changed."""
        if not self.can_redo:
            return ()
        n = self._n_done
        self._doing = n + 1, self._steps[n][1]
        return self._go_on()

    def _go_on(self) -> tuple[str, ...]:
        """Do what is noted to the end: an act, or a step whose changes were made."""
        names: tuple[str, ...] = ()
        if self._open is not None:
            self._add(self._open, scene_of(self._world))
        if self._doing is not None:
            n, act = self._doing
            names = act()
            self._n_done, self._doing = n, None
        return names

    def _add(self, before: Scene, after: Scene) -> None:
        changed = [name for name in before | after if not _equal(before.get(name), after.get(name))]
        if changed:
            old, new = ({name: scene[name] for name in changed if name in scene} for scene in (before, after))
            self._add_acts(partial(self._apply, new, old), partial(self._apply, old, new))
        else:
            self._open = None

    def _add_acts(self, undo: Act, redo: Act) -> None:
        steps = [*self._steps[: self._n_done], (undo, redo)][-_MAX_STEPS:]
        n = len(steps)
        self._steps, self._n_done, self._open = steps, n, None

    def _apply(self, before: Scene, after: Scene) -> tuple[str, ...]:
        exchange(self._world, before.keys() - after.keys(), world_of(after))
        return tuple(after)


def _equal(one: Entry | None, other: Entry | None) -> bool:
    if one is None or other is None:
        return one is other
    same = (one.touch_links, one.speed) == (other.touch_links, other.speed)
    return same and one.shape == other.shape and np.array_equal(one.T, other.T)
