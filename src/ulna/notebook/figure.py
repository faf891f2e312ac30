"""Makes Matplotlib figures that a notebook shows in the last line of a cell, without pyplot."""

from io import BytesIO

from matplotlib.figure import Figure


class NotebookFigure(Figure):
    """A figure whose picture a notebook shows, once, whatever the backend is. No window opens, and pyplot keeps no copy.

    A figure of pyplot is shown twice where an inline backend is on: as the value of the cell, and when the cell ends. A plain
    ``Figure`` is shown only after pyplot has made another one.
    """

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()
