"""Sets q to home, to a named configuration, or to one of a file; and copies and saves q."""

from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.viewer.html import copyable
from ulna.viewer.session.beginning import configurations_of
from ulna.viewer.session.session import Session
from ulna.viewer.typed_fields import refusals_shown

_MOST_BYTES = 1_000_000


class ConfigurationPanel:
    """A list of configurations, and q as text. ``moved`` is called when q was changed."""

    def __init__(self, gui: viser.GuiApi, session: Session, moved: Callable[[], None]) -> None:
        self._session, self._moved = session, moved
        self._known = configurations_of(session.robot)
        self.names = gui.add_button_group("Go to", tuple(self._known))
        with gui.add_folder("Copy, save, load q", expand_by_default=False):
            self.text = gui.add_html("")
            self.save = gui.add_button("Save q", hint="Download q as a .csv file of one row")
            self.load = gui.add_upload_button("Load q", hint="Go to the first row of a .csv file", mime_type="text/csv")
        self.names.on_click(lambda event: self._go(self._known[event.target.value]))
        self.save.on_click(self._download)
        self.load.on_upload(self._upload)
        self._shown = b""

    def show(self, q: NDArray[np.float64]) -> None:
        """Show q, shape (n_dof,), as text that can be copied."""
        if q.tobytes() != self._shown:
            self._shown, words = q.tobytes(), as_text(q)
            self.text.content = copyable(", ".join(f"{value:.4g}" for value in q), "Copy q", words)

    def _go(self, q: NDArray[np.float64]) -> None:
        self._session.q = q
        self._moved()

    def _download(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            content = f"{as_text(self._session.q)}\n".encode()
            event.client.send_file_download(f"{self._session.robot.name}_q.csv", content, save_immediately=True)

    def _upload(self, event: viser.GuiEvent) -> None:
        with refusals_shown(event.client, "q was not loaded"):
            self._go(first_row(self.load.value.content, self._session.robot.n_dof))


def as_text(q: NDArray[np.float64]) -> str:
    """q, shape (n_dof,), with all digits, as ``--q`` reads it."""
    return ", ".join(repr(float(value)) for value in q)


def first_row(content: bytes, n_dof: int) -> NDArray[np.float64]:
    """The first row of a .csv file, shape (n_dof,)."""
    lines = content[:_MOST_BYTES].decode(errors="replace").split("\n")
    words = next((line for line in lines if line.strip()), "").replace(",", " ").split()
    try:
        q = np.array([float(word) for word in words])
    except ValueError:
        raise InputError("q", f"{' '.join(words)[:60]!r}; numbers with commas between them are expected") from None
    if len(q) != n_dof:
        raise InputError("q", f"{len(q)} numbers, but {n_dof} are expected")
    return q
