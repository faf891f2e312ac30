"""Holds a picture or a short film that stays in a notebook, and finds what draws it."""

from base64 import b64encode
from collections.abc import Callable
from html import escape
from pathlib import Path

from ulna.errors import FileError, UlnaError, needs_extra, reason_of

DRAWN_BY = "ulna.pictures"  # the group of entry points: who draws a "robot", a "world" or a "motion"


class Recording:
    """A picture (PNG) or a short film (GIF) as data: a notebook shows it in the last line of a cell, and keeps it in its file.

    Attributes:
        data: The bytes of the file.
        format: ``"png"`` or ``"gif"``.
        size: Width and height [pixels].
        subject: The words for what is shown.
    """

    def __init__(self, data: bytes, kind: str, size: tuple[int, int], subject: str, write: Callable[[Path], object]) -> None:
        self.data, self.format, self.size, self.subject, self._write = data, kind, size, subject, write

    def save(self, path: str | Path) -> None:
        """Write it into a file: as it is, or made again in another format: .mp4 and .gif of a motion, .png of anything.

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
        """A film: notebooks show no GIF by itself, but an image that carries its data."""
        if self.format == "png":
            return None
        words, (width, height) = escape(self.subject, quote=True), self.size
        data = b64encode(self.data).decode("ascii")
        return f'<img src="data:image/{self.format};base64,{data}" width="{width}" height="{height}" alt="{words}">'

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Recording of {self.subject}: {self.format}, {width}x{height}, {len(self.data) / 1e6:.2f} MB>"


def drawer(of: str) -> Callable[..., Recording]:
    """The function that draws a "robot", a "world" or a "motion". An entry point finds it, for it is in a room above.

    Raises:
        MissingExtraError: What it draws with is not installed.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 -- it takes long to import

    found = tuple(entry_points(group=DRAWN_BY, name=of))
    if not found:
        raise UlnaError("the entry points ulna.pictures are missing: install this copy of Ulna again")
    with needs_extra("a picture", "viewer", "trimesh", "av", "PIL"):
        return found[0].load()
