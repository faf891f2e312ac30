"""Starts and stops the server of a page on this machine."""

import contextlib
import errno
import logging
import os
import socket
import sys
import threading
import webbrowser
from collections.abc import Collection, Iterator

import rich
import viser

from ulna.errors import InputError, UlnaError
from ulna.viewer.origin import EVERYWHERE, refusing_foreign_pages
from ulna.viewer.palette import FLOOR_CELLS, FLOOR_SECTIONS

HOST = "127.0.0.1"
_silence = threading.Lock()


class Page:
    """A page of viser to which no page of another origin can connect. ``port=0`` chooses a free port.

    Attributes:
        server: The server.
        url: The address of the page.
        dark: Whether it is dark; at first as the browser prefers in which it is first opened.
        floor: The floor, whose lines are darker on a dark page; None until it is set.
    """

    def __init__(self, host: str = HOST, port: int = 8080, *, title: str = "Ulna", origins: Collection[str] = ()) -> None:
        self._opened = False
        _refuse_busy(host, port)
        logging.getLogger("websockets").setLevel(logging.ERROR)
        try:
            with _quiet(), refusing_foreign_pages(host, origins, title, self._first_tab, self._refuse_upload):
                self.server = viser.ViserServer(host=host, port=port, label=title, verbose=False)
        except UlnaError:  # the server runs, but accepts foreign pages
            self.stop()
            raise
        self.server.request_share_url = lambda verbose=True: None  # noqa: ARG005 - a page must not open a tunnel to the world
        self.floor: viser.GridHandle | None = None
        self._dark_box: viser.GuiCheckboxHandle | None = None
        self.darken(dark=False)
        self.server.gui.main_panel.dock_right()  # people can still move or fold it
        name = EVERYWHERE.get(host, host)
        name = f"[{name}]" if ":" in name else name
        self.url = f"http://{name}:{self.server.get_port()}"

    def open(self) -> None:
        """Open the page in a browser, if this machine has a display; a text browser would block the terminal."""
        if sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            webbrowser.open(self.url)

    @contextlib.contextmanager
    def ending_if_it_fails(self) -> Iterator[None]:
        """A context for building the page: an exception in it stops the server."""
        try:
            yield
        except BaseException:
            self.stop()
            raise

    def darken(self, *, dark: bool) -> None:
        """Show the page in light or dark colours, the floor and its checkbox with it."""
        self.dark = dark
        self.server.gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False, dark_mode=dark)
        if self.floor is not None:
            self.floor.cell_color, self.floor.section_color = FLOOR_CELLS[dark], FLOOR_SECTIONS[dark]
        if self._dark_box is not None and self._dark_box.value != dark:
            self._dark_box.value = dark

    def add_dark_box(self) -> None:
        """Add the checkbox for dark colours where the panel is now."""
        box = self._dark_box = self.server.gui.add_checkbox("Dark", initial_value=self.dark)
        box.on_update(lambda _: self.darken(dark=box.value))

    def _first_tab(self, prefers_dark: bool) -> None:  # noqa: FBT001 - as ``origin`` calls it
        """Begin as the first tab's browser prefers: all tabs show the same."""
        if not self._opened and prefers_dark:
            self.darken(dark=True)
        self._opened = True

    def _refuse_upload(self, words: str) -> None:
        for client in self.server.get_clients().values():
            client.add_notification("The file was not uploaded", words, color="red")

    def stop(self) -> None:
        """Stop the server; open pages show that the connection is lost."""
        with _quiet():
            self.server.stop()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Suppress what viser prints: the caller prints the address itself.

    Only the console that viser uses is silenced, by one page at a time: other threads of the program also write to sys.stdout.
    """
    console = rich.get_console()
    with _silence:
        before, console.quiet = console.quiet, True
        try:
            yield
        finally:
            console.quiet = before


def _refuse_busy(host: str, port: int) -> None:
    """Refuse a port that cannot be used; viser would use the next one without a message."""
    try:
        family = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0][0]
        with socket.create_server((host, port), family=family):
            pass
    except OverflowError:
        raise InputError("port", f"{port} is not a port; 0 to 65535 are") from None
    except OSError as error:
        reason = (error.strerror or str(error)).split(" (while")[0]
        if error.errno == errno.EADDRINUSE:
            raise InputError("port", f"{port} is in use on {host} ({reason}); choose another, or 0 for a free one") from None
        raise InputError("host", f"cannot listen on {host}, port {port} ({reason})") from None
