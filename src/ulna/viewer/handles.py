"""Handles that a person drags in any tab; meanwhile the program does not move them."""

from collections.abc import Callable
from typing import Any

import viser
from numpy.typing import NDArray

from ulna.description.pose import pose, quaternion_from_matrix


class Handles:
    """A transform control. ``moved`` is called, in the server's thread, whenever a person moves or releases it.

    Attributes:
        moved_by_hand: Whether a person has moved it since ``take`` was called.
    """

    def __init__(self, scene: viser.SceneApi, name: str, size: float, moved: Callable[[], None], *, visible: bool = True) -> None:
        self.control = scene.add_transform_controls(name, scale=size, line_width=3.0, depth_test=False, visible=visible)
        self._holders: set[int | None] = set()
        self.moved_by_hand = self._let_go = False
        self._moved = moved
        self.control.on_update(self._update)

    @property
    def held(self) -> bool:
        """Whether it is being dragged in some tab."""
        return bool(self._holders)

    @property
    def pose(self) -> NDArray[Any]:
        """T_base_handles, shape (4, 4)."""
        return pose(self.control.position, wxyz=self.control.wxyz)

    def take(self) -> bool:
        """Whether a person has moved it since the last call."""
        moved, self.moved_by_hand = self.moved_by_hand, False
        return moved

    def take_release(self) -> bool:
        """Whether it was released since the last call, and is dragged in no tab now."""
        let_go, self._let_go = self._let_go, False
        return let_go and not self.held

    def put(self, T: NDArray[Any]) -> None:
        """Move it to a pose, shape (4, 4), unless a person drags it or has just moved it."""
        if not self._holders and not self.moved_by_hand:
            self.control.position, self.control.wxyz = T[:3, 3], quaternion_from_matrix(T)

    def show(self, *, visible: bool) -> None:
        """Show or hide it. Hiding releases it, as the page does not send the end of such a drag."""
        if not visible and self._holders:
            self._holders.clear()
            self._let_go = True
        self.control.visible = visible

    async def _update(self, event: viser.TransformControlsEvent) -> None:
        if event.phase == "end":  # also sent when the tab is closed in which it is dragged
            self._holders.discard(event.client_id)
            self._let_go = True
        elif event.phase == "start":
            self._holders.add(event.client_id)
        else:
            self.moved_by_hand = True
        self._moved()
