"""Paints the pictures of a film in threads, as the kernels release the interpreter's lock."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue

import numpy as np
from numpy.typing import NDArray

from ulna.engine.threads import default_threads
from ulna.viewer.film.model import Model
from ulna.viewer.film.painter import Ground, Painter, Picture

Pixels = NDArray[np.uint8]
_MOST_THREADS = 8  # each has a raster of its own, 60 MB for 1280x720


class Film:
    """Pictures and how to paint them.

    Args:
        model: The robot, with the solids that the pictures show.
        pictures: The pictures, in their order.
        size: Width and height [pixels].
        rate: Pictures a second.
        ground: The floor.
        samples: Samples of a pixel, across and down.
        tell: Called with the number of pictures done so far.
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
        self._n_threads = min(default_threads(), len(pictures), _MOST_THREADS)
        self._painters: SimpleQueue[Painter] = SimpleQueue()  # each thread takes one, and puts it back
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
                if len(ahead) > 2 * self._n_threads:  # keeps at most so many: a film may be larger than memory
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
