"""Makes Matplotlib figures without pyplot, which a notebook shows in the last line of a cell."""

from io import BytesIO

from matplotlib.figure import Figure


class NotebookFigure(Figure):
    """A figure that a notebook shows once, with any backend. No window opens, and pyplot keeps no copy.

    With an inline backend, a figure of pyplot is shown twice: as the value of the cell, and when the cell ends. A plain
    ``Figure`` is shown only after pyplot has made another one.
    """

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()
