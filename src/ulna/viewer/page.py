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
from ulna.viewer.html import BUTTON
from ulna.viewer.origin import EVERYWHERE, refusing_foreign_pages

HOST = "127.0.0.1"
_silence = threading.Lock()


class Page:
    """A page of viser to which no page of a foreign origin can connect. ``port=0`` chooses a free port.

    Attributes:
        server: The server.
        url: The address of the page.
        floor: The floor; None until it is set.
    """

    def __init__(self, host: str = HOST, port: int = 8080, *, title: str = "Ulna", origins: Collection[str] = ()) -> None:
        _refuse_busy(host, port)
        logging.getLogger("websockets").setLevel(logging.ERROR)
        try:
            with _quiet(), refusing_foreign_pages(host, origins, title, self._refuse_upload):
                self.server = viser.ViserServer(host=host, port=port, label=title, verbose=False)
        except UlnaError:  # the server runs, but accepts foreign origins
            self.stop()
            raise
        self.server.request_share_url = lambda verbose=True: None  # noqa: ARG005 - no tunnel to the internet
        self.floor: viser.GridHandle | None = None
        self.server.gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False)
        self.server.gui.main_panel.dock_right()  # a person can still move or fold it
        name = EVERYWHERE.get(host, host)
        name = f"[{name}]" if ":" in name else name
        self.url = f"http://{name}:{self.server.get_port()}"

    def open(self) -> None:
        """Open the page in a browser if this machine has a display. A text browser would block the terminal."""
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

    def add_dark_button(self) -> None:
        """Add a button that switches between light and dark colors in the browser that shows it."""
        self.server.gui.add_html(
            f'<div style="padding:0 0.75em 0.5em"><button data-dark style="{BUTTON}">Light or dark theme</button></div>'
        )

    def _refuse_upload(self, words: str) -> None:
        for client in self.server.get_clients().values():
            client.add_notification("The file was not uploaded", words, color="red")

    def stop(self) -> None:
        """Stop the server; open pages show that the connection is lost."""
        with _quiet():
            self.server.stop()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """A context in which viser prints nothing; the caller prints the address itself.

    Only the console that viser uses is silenced, by one page at a time. Other threads of the program may write to sys.stdout.
    """
    console = rich.get_console()
    with _silence:
        before, console.quiet = console.quiet, True
        try:
            yield
        finally:
            console.quiet = before


def _refuse_busy(host: str, port: int) -> None:
    """Raise an InputError if the port cannot be used; viser would silently use the next one."""
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
