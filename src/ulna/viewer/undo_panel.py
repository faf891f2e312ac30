"""Buttons and keys that undo and redo the steps of a person on the page, in every tab."""

from collections.abc import Callable

import viser

from ulna.viewer.session.scene_history import SceneHistory


class UndoPanel:
    """Two buttons and two keys. ``step_by`` connects them to a history."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self.undo = gui.add_button("Undo", hint="Undo the last change (Ctrl-Z)", color="gray", disabled=True)
        self.redo = gui.add_button("Redo", hint="Redo the last undone change (Ctrl-Shift-Z)", color="gray", disabled=True)

    def step_by(self, history: SceneHistory, step: Callable[[Callable[[], tuple[str, ...]]], None]) -> None:
        """Call ``step`` with the method of a history, ``undo`` or ``redo``, at each click or key."""
        self._history = history
        for button, act, words, modifier in (
            (self.undo, history.undo, "Undo the last change", "cmd/ctrl"),
            (self.redo, history.redo, "Redo the last undone change", "cmd/ctrl+shift"),
        ):
            button.on_click(lambda _, act=act: step(act))
            self._gui.add_command(words, hotkey="Z", modifier=modifier).on_trigger(lambda _, act=act: step(act))  # type: ignore[arg-type]

    def show(self) -> None:
        """Enable the buttons that have a step to undo or redo."""
        self.undo.disabled, self.redo.disabled = not self._history.can_undo, not self._history.can_redo
