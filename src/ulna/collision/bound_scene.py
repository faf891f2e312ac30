"""Binds compiled functions to a scene, so that their callers pass only the other arguments.

A *scene* contains the tables of a robot and of the objects of a world (``kernels.collision.scene``). The compiled functions,
called *entries*, take it as their first argument (``engine.entries``).
"""

from collections.abc import Callable
from typing import Any, TypeVar

from ulna.engine.bound import bind_first
from ulna.kernels.collision.scene import Scene

ResultT = TypeVar("ResultT")
_BOXES, _SHAPES = 0, 1  # signatures of all entries that take a scene: ``BOXES`` and ``SHAPES`` of ``kernels.collision.scene``


class BoundScene:
    """A scene, and the entries bound to it as their first argument. An entry is bound at its first use."""

    __slots__ = "_entries", "_signature", "scene"

    def __init__(self, scene: Scene) -> None:
        """Take a scene, as ``collision.bodies.scene_of`` makes it."""
        self.scene = scene
        self._signature = _BOXES if scene.vertices is None else _SHAPES
        self._entries: dict[Any, Any] = {}

    def with_rows(self, first: int, end: int) -> "BoundScene":
        """The scene with the objects in these rows of the same table; itself if the rows are unchanged."""
        if self.scene.first == first and self.scene.end == end:
            return self
        return BoundScene(self.scene._replace(first=first, end=end))

    def bound(self, entry: Callable[..., ResultT]) -> Callable[..., ResultT]:
        """An entry bound to the scene: a function of its other arguments, with their declared types."""
        bound = self._entries.get(entry)
        if bound is None:
            bound = self._entries[entry] = bind_first(entry, self._signature, self.scene)
        return bound
