"""The tab Steer: held buttons move the hand or single joints, and a line shows the status of the servo.

Keys and gamepads press the buttons by a script of the page (``head.html``).
"""

import time
from collections.abc import Callable
from functools import partial

import numpy as np
import viser

from ulna.kinematics.frames import standing_links
from ulna.robot.coordinates import coordinates_of
from ulna.servo.command import CommandStatus
from ulna.viewer.html import small_text, status_line
from ulna.viewer.palette import AXES, GREEN, RED, STOPPED, UNKNOWN
from ulna.viewer.session.session import Session
from ulna.viewer.session.steering import JOINTS, Steering

_KEYS = {"x": ("↑", "↓"), "y": ("←", "→"), "z": ("PgUp", "PgDn")}  # of the positive and the negative direction
_WHAT = (
    "Hold a button or its key, and the hand moves until you let go. It slows down and stops before an obstacle, and a sentence "
    "names the reason. To make the floor an obstacle, tick it in Obstacles."
)
_AXES = {"base": "base", "hand": "link", "joints": JOINTS}  # the list also has the other fixed links, by their names
_STEPS = {"while held": 0.0, "1 mm or 0.5°": 1.0, "1 cm or 5°": 10.0, "5 cm or 25°": 50.0}  # [mm or 0.5 degrees]
_MM, _HALF_A_DEGREE = 1e-3, np.radians(0.5)
_LONGEST_FRAME = 0.1  # [s] so that the arm does not jump after a pause
_EVERY = 10.0  # [1/s] messages of a held button
_FINE = {
    CommandStatus.FOLLOWING,
    CommandStatus.AT_REST,
    CommandStatus.BRAKING,
    CommandStatus.LIMITED_BY_ACCELERATION,
    CommandStatus.LIMITED_BY_JERK,
}


class SteerPanel:
    """The tab Steer. ``on_event`` is called after each event."""

    def __init__(
        self, gui: viser.GuiApi, session: Session, on_event: Callable[[], None], *, on: bool, jerk: float | None = None
    ) -> None:
        self._session, self._on_event, self.steering = session, on_event, Steering(session, jerk)
        refusal = session.unchecked
        gui.add_html(small_text(_WHAT))
        self.begin = gui.add_button("Steer the hand", disabled=bool(refusal), hint=refusal or None)
        self.sentence = gui.add_html(small_text(refusal) if refusal else "")
        self.free = gui.add_button(
            "Go to a free pose", hint="Jump to the nearest collision-free pose that is found", color="orange", visible=False
        )
        self.buttons = [
            gui.add_button(f"{word} {'+-'[k]}{axis}  [{shift}{_KEYS[axis][k]}]", color=AXES[axis], visible=False)
            for word, shift in (("move", ""), ("turn", "⇧"))
            for k in (0, 1)
            for axis in _KEYS
        ]
        self.joints = [
            gui.add_button(f"{'-+'[k]} {coordinate.name}", color="gray", visible=False)
            for coordinate in coordinates_of(session.robot)
            for k in (0, 1)
        ]
        tree = session.robot.tree
        others = [f"axes of {name}" for name in standing_links(tree) if name != tree.root]
        self.axes = gui.add_dropdown("Move along", (*_AXES, *others), initial_value="base", visible=False)
        self.step = gui.add_dropdown("Step", tuple(_STEPS), initial_value="while held", visible=False)
        self.speed = gui.add_slider("Speed [m/s]", min=0.01, max=0.5, step=0.01, initial_value=self.steering.speed, visible=False)
        self.stop = gui.add_button("End steering", color="gray", visible=False)
        hand = [(3 * turn + axis, 1 - 2 * k) for turn in (0, 1) for k in (0, 1) for axis in range(3)]
        joints = [(k // 2, 2 * (k % 2) - 1) for k in range(len(self.joints))]
        for button, (entry, sign) in zip((*self.buttons, *self.joints), (*hand, *joints), strict=True):
            button.on_hold(partial(self._hold, entry, sign), callback_hz=_EVERY)
            button.on_click(partial(self._click, entry, sign))
        self.begin.on_click(lambda _: self._do(lambda: self.steering.turn(on=True)))
        self.stop.on_click(lambda _: self._do(lambda: self.steering.turn(on=False)))
        self.free.on_click(lambda _: self._do(self.steering.go_free))
        self.speed.on_update(lambda _: self._do(self._choose))
        self.axes.on_update(lambda _: self._do(self._choose))
        self._last, self._acted = time.perf_counter(), True
        if on and not refusal:
            self.steering.turn(on=True)

    @property
    def moving(self) -> bool:
        """Whether the arm moves."""
        return self.steering.moving

    def apply_input(self) -> bool:
        """Advance the arm. Returns whether the content of the tab has changed."""
        now = time.perf_counter()
        seconds, self._last = min(now - self._last, _LONGEST_FRAME), now
        acted, self._acted = self._acted, False
        return self.steering.frame(seconds) or acted

    def show(self) -> None:
        """Show the buttons and the status of the servo."""
        steering, command = self.steering, self.steering.command
        self.begin.visible = not steering.on
        for element in (self.speed, self.axes, self.step, self.stop):
            element.visible = steering.on
        by_joints = steering.expressed_in == JOINTS
        for buttons, shown in ((self.buttons, not by_joints), (self.joints, by_joints)):
            for button in buttons:
                button.visible, button.disabled = steering.on and shown, not steering.can_move
        self.free.visible = bool(steering.refusal) and steering.on
        color = UNKNOWN if command is None else GREEN if command.status in _FINE else STOPPED
        if steering.refusal or (command is not None and command.status == CommandStatus.NOT_CERTIFIED):
            color = RED
        if not self._session.unchecked:
            self.sentence.content = status_line(steering.sentence, color) if steering.on else ""

    async def _hold(self, entry: int, sign: int, _: viser.GuiEvent) -> None:
        if not _STEPS[self.step.value]:
            self._do(lambda: self.steering.hold(entry, sign))

    async def _click(self, entry: int, sign: int, _: viser.GuiEvent) -> None:
        """Move by a step, if the person has chosen a step size."""
        if n := _STEPS[self.step.value]:
            size = n * (_HALF_A_DEGREE if self.steering.turns[entry] else _MM)
            self._do(lambda: self.steering.step(entry, sign, size))

    def _choose(self) -> None:
        axes = self.axes.value
        self.steering.speed, self.steering.axes_of = self.speed.value, None if axes in _AXES else axes.removeprefix("axes of ")
        self.steering.expressed_in = _AXES.get(axes, "base")

    def _do(self, act: Callable[[], object]) -> None:
        with self._session.lock:
            act()
            self._acted = True
        self._on_event()
