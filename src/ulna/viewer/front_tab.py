"""Keeps track of the front tab of the panel in each browser.

A script of the page (``head.html``) clicks a hidden button with the name of the tab.
"""

from collections.abc import Callable
from functools import partial

import viser

_WORDS = "in front: "  # the label of a hidden button begins with these words, by which the script finds it


class FrontTabs:
    """The tab in front in each browser. ``on_event`` is called when it changes."""

    def __init__(self, server: viser.ViserServer, names: tuple[str, ...], on_event: Callable[[], None]) -> None:
        self._front_tabs: dict[int, str] = {}  # the name of the tab, by the number of the browser
        self._on_event = on_event
        for name in names:
            server.gui.add_button(f"{_WORDS}{name}").on_click(partial(self._note, name))
        server.on_client_disconnect(self._forget)

    def shows(self, name: str) -> bool:
        """Whether a tab is in front in any browser; True until the first browser has reported its tab."""
        return not self._front_tabs or name in self._front_tabs.values()

    async def _note(self, name: str, event: viser.GuiEvent) -> None:
        if event.client_id is not None:
            self._front_tabs[event.client_id] = name
            self._on_event()

    def _forget(self, client: viser.ClientHandle) -> None:
        self._front_tabs.pop(client.client_id, None)
        self._on_event()
