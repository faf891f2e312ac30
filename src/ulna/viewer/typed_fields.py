"""Collects the values typed into fields until a frame takes them, shows their errors, and shows poses in fields."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.description.pose import pose, rpy_from_matrix
from ulna.errors import UlnaError
from ulna.viewer.session.planned_motion import Planning
from ulna.viewer.session.session import Session

_DIGITS = 4  # decimals: 0.1 mm


@contextmanager
def refusals_shown(client: viser.ClientHandle | None, title: str) -> Iterator[None]:
    """A context whose UlnaErrors are shown in a person's browser instead of raised."""
    try:
        yield
    except UlnaError as error:
        if client is not None:
            client.add_notification(title, str(error), color="red")


class Typed(NamedTuple):
    """The last value typed into a field.

    Attributes:
        field: The field.
        value: The value.
        chosen: The name that was chosen at that time.
        client: The browser in which it was typed.
    """

    field: Any
    value: Any
    chosen: str
    client: viser.ClientHandle


class TypedFields:
    """Fields whose typed values ``write`` does not overwrite until ``pop_values``. ``on_event`` is called after each one."""

    def __init__(self, fields: tuple[Any, ...], on_event: Callable[[], None], chosen: Callable[[], str] = str) -> None:
        self._typed: dict[int, Typed] = {}
        self._on_event, self._chosen = on_event, chosen
        for field in fields:
            field.on_update(self._listen)

    def pop_values(self) -> list[Typed]:
        """Return the values typed since the last call."""
        typed, self._typed = self._typed, {}
        return list(typed.values())

    def write(self, field: Any, value: Any) -> None:
        """Show a value in a field, unless a person has just typed there."""
        if id(field) not in self._typed:
            field.value = value

    def write_pose(self, xyz: Any, rpy: Any, T: NDArray[Any]) -> None:
        """Show a pose, shape (4, 4), in a field for its position and one for its angles."""
        self.write(xyz, rounded(T[:3, 3]))
        self.write(rpy, rounded(rpy_from_matrix(T)))

    async def _listen(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._typed[id(event.target)] = Typed(event.target, event.target.value, self._chosen(), event.client)
            self._on_event()


def retype_position(T: NDArray[Any], typed: tuple[float, ...]) -> None:
    """Set the position of a pose, shape (4, 4), in place to the typed one [m]."""
    T[:3, 3] = _retyped(T[:3, 3], typed)


def retype_angles(T: NDArray[Any], typed: tuple[float, ...]) -> None:
    """Set the rotation of a pose, shape (4, 4), in place to the typed roll, pitch and yaw [rad]."""
    T[:3, :3] = pose(rpy=_retyped(rpy_from_matrix(T), typed))[:3, :3]


def _retyped(exact: NDArray[Any], typed: tuple[float, ...]) -> NDArray[Any]:
    """The typed numbers; the exact ones where the typed number is the rounded one that the field showed."""
    return np.where(np.equal(typed, rounded(exact)), exact, typed)


def rounded(values: NDArray[Any]) -> tuple[float, ...]:
    """Numbers as a field shows them."""
    return tuple(float(value) + 0.0 for value in values.round(_DIGITS))


class HandPose:
    """Two fields, position and angles, of a pose in a frame that a person chooses.

    A typed pose becomes the target of a session's hand, or the goal of a plan.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        sent: Session | Planning,
        on_event: Callable[[], None],
        name: str = "Hand",
        *,
        visible: bool = True,
    ) -> None:
        self._sent = sent
        zero = (0.0, 0.0, 0.0)
        where = (
            "Position of the hand in the frame; type another to move it"
            if name == "Hand"
            else "Position of the goal in the frame"
        )
        turned = f"Roll, pitch, yaw of the {name.lower()} in the frame"
        frames = tuple(sent.frames)
        self.frame = gui.add_dropdown(
            "In the frame of", frames, initial_value=frames[0], hint="A fixed link or an obstacle", visible=False
        )
        self._on_event = on_event
        self.frame.on_update(self._choose)
        self.xyz = gui.add_vector3(f"{name} xyz [m]", zero, step=0.001, hint=where, visible=visible)
        self.rpy = gui.add_vector3(f"{name} rpy [rad]", zero, step=0.001, hint=turned, visible=visible)
        self._fields = TypedFields((self.xyz, self.rpy), on_event)

    def apply_input(self) -> None:
        """Send the hand to the pose typed since the last call."""
        typed = self._fields.pop_values()
        if not typed:
            return
        frame = self._frame(self._sent.frames)
        T = np.linalg.solve(frame, self._sent.hand_pose if self._sent.target is None else self._sent.target)
        with refusals_shown(typed[0].client, "Not changed"):
            for field, value, _, _ in typed:
                (retype_position if field is self.xyz else retype_angles)(T, value)
            self._sent.send(frame @ T)

    def show(self, *, visible: bool = True) -> None:
        """Show the pose of the hand, except in a field that was just typed in.

        The choice of a frame is shown if there are several.
        """
        frames = self._sent.frames
        if (names := tuple(frames)) != self.frame.options:
            chosen = self.frame.value if self.frame.value in names else names[0]
            self.frame.options, self.frame.value = names, chosen
        self.frame.visible = visible and len(names) > 1
        for field in (self.xyz, self.rpy):
            field.visible = visible
        self._fields.write_pose(self.xyz, self.rpy, np.linalg.solve(self._frame(frames), self._sent.hand_pose))

    def _frame(self, frames: dict[str, NDArray[Any]]) -> NDArray[Any]:
        """T_base_frame of the chosen frame, shape (4, 4); the identity if it no longer exists."""
        return frames.get(self.frame.value, np.eye(4))

    def _choose(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._on_event()
