"""Shows the hand's pose in fields that can be edited. Used by ``hand``."""

from collections.abc import Callable

import viser

from ulna.description.pose import pose, rpy_from_matrix
from ulna.errors import UlnaError
from ulna.viewer.retyped import retyped, rounded
from ulna.viewer.session.session import Session


class HandPose:
    """Two fields, position and angles. A typed pose sends the hand there. ``moved`` is called after something was typed."""

    def __init__(self, gui: viser.GuiApi, session: Session, moved: Callable[[], None]) -> None:
        self._session, self._moved = session, moved
        self._typed: dict[str, tuple[tuple[float, ...], viser.ClientHandle]] = {}
        zero = (0.0, 0.0, 0.0)
        self.xyz = gui.add_vector3("Hand xyz [m]", zero, step=0.001, hint="Where the hand is in the base frame; type where to go")
        self.rpy = gui.add_vector3("Hand rpy [rad]", zero, step=0.001, hint="Roll, pitch, yaw of the hand in the base frame")
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

    def _listener(self, name: str) -> Callable:
        async def listen(event: viser.GuiEvent) -> None:
            if event.client is not None:
                self._typed[name] = (event.target.value, event.client)
                self._moved()

        return listen
