"""Steers the hand by buttons that are held, or by their keys (``head.html``), and shows what limits it."""

import time
from collections.abc import Callable
from functools import partial

import viser

from ulna.servo.command import CommandStatus
from ulna.viewer.html import marked, small_text
from ulna.viewer.palette import GREEN, RED, STOPPED, UNKNOWN
from ulna.viewer.session.session import Session
from ulna.viewer.session.steering import Steering

_KEYS = {"x": ("↑", "↓"), "y": ("←", "→"), "z": ("PgUp", "PgDn")}  # of the positive and of the negative direction
_HINT = "Hold a button, or its key, and the hand moves; it touches nothing, and comes to rest when you let go"
_AXES = {"base": "base", "hand": "link"}
_LONGEST_FRAME = 0.1  # [s] after a pause the arm does not jump
_EVERY = 10.0  # [1/s]: messages of a button that is held
_FINE = {
    CommandStatus.FOLLOWING,
    CommandStatus.AT_REST,
    CommandStatus.BRAKING,
    CommandStatus.LIMITED_BY_ACCELERATION,
    CommandStatus.LIMITED_BY_JERK,
}


class SteerPanel:
    """The tab of steering. ``moved`` is called after each event."""

    def __init__(
        self, gui: viser.GuiApi, session: Session, moved: Callable[[], None], *, on: bool, jerk: float | None = None
    ) -> None:
        self._session, self._moved, self.steering = session, moved, Steering(session, jerk)
        refusal = session.unchecked
        self.on = gui.add_checkbox("Steer the hand", initial_value=False, disabled=bool(refusal), hint=refusal or _HINT)
        self.sentence = gui.add_html(small_text(refusal) if refusal else "")
        self.speed = gui.add_slider("Speed [m/s]", min=0.01, max=0.5, step=0.01, initial_value=self.steering.speed, visible=False)
        self.axes = gui.add_dropdown("Axes", tuple(_AXES), initial_value="base", visible=False)
        self.buttons = [
            gui.add_button(f"{word} {'+-'[k]}{axis}  [{shift}{keys[k]}]", visible=False)
            for word, shift in (("move", ""), ("turn", "⇧"))
            for axis, keys in _KEYS.items()
            for k in (0, 1)
        ]
        for k, button in enumerate(self.buttons):
            button.on_hold(partial(self._hold, k // 2, 1 - 2 * (k % 2)), callback_hz=_EVERY)
        self.on.on_update(lambda _: self._do(lambda: self.steering.turn(on=self.on.value)))
        self.speed.on_update(lambda _: self._do(self._choose))
        self.axes.on_update(lambda _: self._do(self._choose))
        self._last, self._acted = time.perf_counter(), True
        if on and not refusal:
            self.on.value = True
            self.steering.turn(on=True)

    @property
    def moving(self) -> bool:
        """Whether the arm moves."""
        return self.steering.moving

    def take(self) -> bool:
        """Move the arm on. Returns whether the tab shows something else."""
        now = time.perf_counter()
        seconds, self._last = min(now - self._last, _LONGEST_FRAME), now
        acted, self._acted = self._acted, False
        return self.steering.frame(seconds) or acted

    def show(self) -> None:
        """Show the buttons, and what limits the hand."""
        steering, command = self.steering, self.steering.command
        for element in (self.speed, self.axes, *self.buttons):
            element.visible = steering.on
        color = UNKNOWN if command is None else GREEN if command.status in _FINE else STOPPED
        if steering.refusal or (command is not None and command.status == CommandStatus.NOT_CERTIFIED):
            color = RED
        if not self._session.unchecked:
            self.sentence.content = marked(steering.sentence, color, filled=command is not None) if steering.on else ""

    async def _hold(self, entry: int, sign: int, _: viser.GuiEvent) -> None:
        self._do(lambda: self.steering.hold(entry, sign))

    def _choose(self) -> None:
        self.steering.speed, self.steering.expressed_in = self.speed.value, _AXES[self.axes.value]

    def _do(self, act: Callable[[], object]) -> None:
        with self._session.lock:
            act()
            self._acted = True
        self._moved()
