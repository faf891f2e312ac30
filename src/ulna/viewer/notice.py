"""Shows that kernels are being compiled, and that a frame has failed."""

import html

import viser

from ulna.viewer.html import STYLE


class Notice:
    """A line of the panel, hidden while it is empty."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._element = gui.add_html("", visible=False)
        self._compiling: tuple[str, ...] = ()
        self._failure = ""

    @property
    def text(self) -> str:
        """Its text; empty if there is nothing to report."""
        if self._failure:
            return f"This picture is not up to date. {self._failure}"
        if self._compiling:
            first, *rest = self._compiling
            more = f"; {len(rest)} more to come" if rest else ""
            return f"Compiling for this machine (once): {first}{more}"
        return ""

    def show_compiling(self, names: tuple[str, ...]) -> None:
        """Show the names of what is being compiled."""
        if names != self._compiling:
            self._compiling = names
            self._write()

    def show_failure(self, error: Exception | None) -> None:
        """Show why the last frame failed; None if it did not."""
        self._failure = "" if error is None else f"{type(error).__name__}: {error}"
        self._write()

    def _write(self) -> None:
        role = "alert" if self._failure else "log"
        self._element.content = f'<div role="{role}" style="{STYLE};font-size:0.85em">{html.escape(self.text)}</div>'
        self._element.visible = bool(self.text)
