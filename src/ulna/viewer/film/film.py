"""Paints the pictures of a film in threads, and writes them to a file: .mp4, .gif or .png."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from errno import EISDIR
from pathlib import Path
from queue import SimpleQueue

import av
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from numpy.typing import NDArray
from PIL import Image

from ulna.engine.threads import n_threads
from ulna.errors import FileError, reason_of
from ulna.viewer.film.painter import Ground, Painter, Picture
from ulna.viewer.film.skin import Model

Pixels = NDArray[np.uint8]
_MAX_THREADS = 8  # each has its own raster, 60 MB for 1280x720


class Film:
    """Pictures, and the painters that paint them.

    Args:
        model: The robot.
        pictures: The pictures in their order, each with its own solids.
        size: Width and height [pixels].
        rate: Pictures per second.
        ground: The floor.
        samples: The number of samples per pixel, across and down.
        tell: Called with the number of finished pictures.
    """

    def __init__(
        self,
        model: Model,
        pictures: Sequence[Picture],
        size: tuple[int, int],
        rate: int,
        ground: Ground,
        samples: int = 2,
        tell: Callable[[int], object] = lambda _: None,
    ) -> None:
        self.pictures, self.size, self.rate = pictures, size, rate
        self._tell = tell
        self._n_threads = min(n_threads(), len(pictures), _MAX_THREADS)
        self._painters: SimpleQueue[Painter] = SimpleQueue()  # each thread takes a painter, and puts it back
        for _ in range(self._n_threads):
            self._painters.put(Painter(model, size, ground, samples))

    def __len__(self) -> int:
        return len(self.pictures)

    def frames(self) -> Iterator[Pixels]:
        """The pixels of every picture, in their order, shape (height, width, 3)."""
        with ThreadPoolExecutor(self._n_threads, thread_name_prefix="ulna-film") as pool:
            ahead: deque = deque()
            for k, picture in enumerate(self.pictures):
                ahead.append(pool.submit(self._paint, picture))
                if len(ahead) > 2 * self._n_threads:  # a bound, since a film may be larger than memory
                    yield ahead.popleft().result()
                    self._tell(k + 1 - len(ahead))
            while ahead:
                yield ahead.popleft().result()
                self._tell(len(self) - len(ahead))

    def some(self, n: int) -> list[Pixels]:
        """The pixels of n pictures, evenly spaced."""
        places = np.linspace(0, len(self) - 1, min(n, len(self)))
        return [self._paint(self.pictures[k]) for k in places.astype(int)]

    def _paint(self, picture: Picture) -> Pixels:
        painter = self._painters.get()
        try:
            return painter.paint(picture)
        finally:
            self._painters.put(painter)


_STEADY = "mbtree=0"  # with macroblock trees the output of x264 varies from run to run on some processors
_QUALITY = "20"  # constant rate factor of H.264: 0 is lossless, 51 the worst
_THREADS = 4  # of the encoder: fixed, since the output depends on their number
_COLORS = 255  # of a .gif: the last of its 256 is reserved for unchanged pixels
_LOOKED_AT = 30  # frames from which the colors are chosen


def write_film(path: Path, film: Film) -> None:
    """Write a film in the format of its path's ending.

    It writes to a temporary file and then renames it, so that no incomplete file remains.

    Raises:
        FileError: The file cannot be written.
    """
    unfinished = path.with_name(f".{path.name}.part")
    try:
        if path.is_dir():
            raise IsADirectoryError(EISDIR, "it is a folder")
        unfinished.touch()
        try:
            WRITERS[path.suffix.lower()](unfinished, film)
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(str(path), f"cannot be written: {reason_of(error, missing='no such folder')}") from None


def _write_mp4(path: Path, film: Film) -> None:
    """Write a video that every browser plays: H.264 in the colors of HD television (BT.709)."""
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=film.rate, options={"crf": _QUALITY, "x264-params": _STEADY})
        stream.width, stream.height = film.size
        stream.pix_fmt, stream.thread_count = "yuv420p", _THREADS
        stream.colorspace, stream.color_range = Colorspace.ITU709, ColorRange.MPEG
        for pixels in film.frames():
            frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
            frame = frame.reformat(format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def _write_gif(path: Path, film: Film) -> None:
    """Write a .gif that repeats forever. One palette for all frames keeps still parts unchanged."""
    palette = _palette(np.concatenate(film.some(_LOOKED_AT)))
    frames = (Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE) for pixels in film.frames())
    ticks = np.diff(np.round(np.arange(len(film) + 1) * 100 / film.rate)) * 10  # the format counts hundredths of a second
    next(frames).save(path, "GIF", save_all=True, append_images=frames, duration=ticks.astype(int).tolist(), loop=0)


def _palette(pixels: NDArray[np.uint8]) -> Image.Image:
    """A palette for the colors of pictures. Rare colors have a higher weight, since a small red light matters."""
    six_bits = (pixels.reshape(-1, 3) >> 2).astype(np.int32)
    counts = np.bincount(six_bits @ np.array([1 << 12, 1 << 6, 1], np.int32), minlength=1 << 18)
    codes = np.flatnonzero(counts)
    votes = np.clip(np.sqrt(counts[codes]) / 8, 1, 64).astype(int)
    colors = np.stack([codes >> 12, codes >> 6 & 63, codes & 63], axis=-1) * 4 + 2
    voters = colors.repeat(votes, axis=0)[None].astype(np.uint8)
    return Image.fromarray(voters).quantize(_COLORS, Image.Quantize.MEDIANCUT, kmeans=1)


def _write_png(path: Path, film: Film) -> None:
    """Write the first picture."""
    Image.fromarray(next(film.frames())).save(path, "PNG", optimize=True)


WRITERS: dict[str, Callable[[Path, Film], None]] = {".mp4": _write_mp4, ".gif": _write_gif, ".png": _write_png}
