"""Knows which tab of the panel is in front in each browser: a script of the page clicks a button of its name (``head.html``)."""

from collections.abc import Callable
from functools import partial

import viser

_WORDS = "in front: "  # how such a button begins, by which the script finds it and hides it


class FrontTabs:
    """The tab in front in each browser. ``moved`` is called when it is another."""

    def __init__(self, server: viser.ViserServer, names: tuple[str, ...], moved: Callable[[], None]) -> None:
        self._of: dict[int, str] = {}  # by the browser
        self._moved = moved
        for name in names:
            server.gui.add_button(f"{_WORDS}{name}").on_click(partial(self._note, name))
        server.on_client_disconnect(self._forget)

    def shows(self, name: str) -> bool:
        """Whether a tab is in front in any browser; True while no browser has said which is."""
        return not self._of or name in self._of.values()

    async def _note(self, name: str, event: viser.GuiEvent) -> None:
        if event.client_id is not None:
            self._of[event.client_id] = name
            self._moved()

    def _forget(self, client: viser.ClientHandle) -> None:
        self._of.pop(client.client_id, None)
        self._moved()
