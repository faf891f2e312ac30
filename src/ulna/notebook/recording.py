"""Holds a picture or a short film for a notebook, and finds the function that draws it."""

from base64 import b64encode
from collections.abc import Callable
from html import escape
from pathlib import Path

from ulna.errors import FileError, UlnaError, needs_extra, reason_of

DRAWN_BY = "ulna.pictures"  # the group of entry points that draw a "robot", a "world" or a "motion"


class Recording:
    """A picture (PNG) or a short film (GIF) as data, which a notebook shows and stores in its file.

    Attributes:
        data: The bytes of the file.
        format: ``"png"`` or ``"gif"``.
        size: Width and height [pixels].
        subject: A description of the content.
    """

    def __init__(self, data: bytes, kind: str, size: tuple[int, int], subject: str, write: Callable[[Path], object]) -> None:
        self.data, self.format, self.size, self.subject, self._write = data, kind, size, subject, write

    def save(self, path: str | Path) -> None:
        """Write it to a file, rendered again for another format: .mp4 and .gif of a motion, .png of anything.

        Raises:
            FileError: The file cannot be written.
            InputError: The path ends in none of the formats.
        """
        path = Path(path)
        if path.suffix.lower() != f".{self.format}":
            self._write(path)
            return
        try:
            path.write_bytes(self.data)
        except OSError as error:
            raise FileError(str(path), f"cannot be written: {reason_of(error, missing='no such folder')}") from None

    def _repr_png_(self) -> bytes | None:
        return self.data if self.format == "png" else None

    def _repr_html_(self) -> str | None:
        """A film as an image element that contains its data, since notebooks do not show a GIF itself."""
        if self.format == "png":
            return None
        words, (width, height) = escape(self.subject, quote=True), self.size
        data = b64encode(self.data).decode("ascii")
        return f'<img src="data:image/{self.format};base64,{data}" width="{width}" height="{height}" alt="{words}">'

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Recording of {self.subject}: {self.format}, {width}x{height}, {len(self.data) / 1e6:.2f} MB>"


def drawer(of: str) -> Callable[..., Recording]:
    """Find the function that draws a "robot", a "world" or a "motion", by an entry point of a higher layer.

    Raises:
        MissingExtraError: The package for drawing is not installed.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 -- it takes long to import

    found = tuple(entry_points(group=DRAWN_BY, name=of))
    if not found:
        raise UlnaError("the entry points ulna.pictures are missing: install this copy of Ulna again")
    with needs_extra("a picture", "viewer", "trimesh", "av", "PIL"):
        return found[0].load()
