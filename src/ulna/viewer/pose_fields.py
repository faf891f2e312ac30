"""Shows a hand's pose in fields that can be edited, and rounds numbers for fields."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.pose import pose, rpy_from_matrix
from ulna.errors import UlnaError

_DIGITS = 4  # decimals: tenths of millimetres


def retyped(exact: NDArray[Any], typed: tuple[float, ...]) -> NDArray[Any]:
    """The typed numbers where they differ from the rounded ones that the form showed; the exact numbers elsewhere."""
    return np.where(np.equal(typed, rounded(exact)), exact, typed)


def rounded(values: NDArray[Any]) -> tuple[float, ...]:
    """Numbers as the form shows them."""
    return tuple(float(value) + 0.0 for value in values.round(_DIGITS))


class Sent(Protocol):
    """What is sent to a typed pose: the hand of a ``Session``, or the goal of a ``Planning``."""

    @property
    def target(self) -> NDArray | None:
        """The pose to which it is pulled, shape (4, 4); None if it is not pulled."""
        ...

    @property
    def hand_pose(self) -> NDArray:
        """Where it is, shape (4, 4)."""
        ...

    def send(self, T_base_hand: NDArray) -> None:
        """Send it to a pose, shape (4, 4)."""
        ...


class HandPose:
    """Two fields, position and angles. A typed pose sends the hand there. ``moved`` is called after something was typed."""

    def __init__(
        self, gui: viser.GuiApi, session: Sent, moved: Callable[[], None], name: str = "Hand", *, visible: bool = True
    ) -> None:
        self._session, self._moved = session, moved
        self._typed: dict[str, tuple[tuple[float, ...], viser.ClientHandle]] = {}
        zero = (0.0, 0.0, 0.0)
        where = "Where the hand is in the base frame; type where to go" if name == "Hand" else "Where the hand is to go"
        turned = f"Roll, pitch, yaw of the {name.lower()} in the base frame"
        self.xyz = gui.add_vector3(f"{name} xyz [m]", zero, step=0.001, hint=where, visible=visible)
        self.rpy = gui.add_vector3(f"{name} rpy [rad]", zero, step=0.001, hint=turned, visible=visible)
        self.xyz.on_update(self._listener("xyz"))
        self.rpy.on_update(self._listener("rpy"))

    def take(self) -> None:
        """Send the hand to what was typed since the last call."""
        typed, self._typed = self._typed, {}
        if not typed:
            return
        T = self._session.hand_pose if self._session.target is None else self._session.target.copy()
        try:
            if "xyz" in typed:
                T[:3, 3] = retyped(T[:3, 3], typed["xyz"][0])
            if "rpy" in typed:
                T[:3, :3] = pose(rpy=retyped(rpy_from_matrix(T), typed["rpy"][0]))[:3, :3]
            self._session.send(T)
        except UlnaError as error:
            _, client = next(iter(typed.values()))
            client.add_notification("Not changed", str(error), color="red")

    def show(self) -> None:
        """Show the pose of the hand, except in a field that was just typed in."""
        T = self._session.hand_pose
        for name, field, values in (("xyz", self.xyz, T[:3, 3]), ("rpy", self.rpy, rpy_from_matrix(T))):
            if name not in self._typed:
                x, y, z = rounded(values)
                field.value = (x, y, z)

    def show_fields(self, *, visible: bool) -> None:
        """Show or hide the fields."""
        self.xyz.visible = self.rpy.visible = visible

    def _listener(self, name: str) -> Callable:
        async def listen(event: viser.GuiEvent) -> None:
            if event.client is not None:
                self._typed[name] = (event.target.value, event.client)
                self._moved()

        return listen
