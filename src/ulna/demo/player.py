"""The demo as it runs on a screen: where the arm stands, and what a drag of the box does."""

import threading
import time
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.demo.scenario import Demo


class Screen(Protocol):
    """What draws: the page in a browser, or a node that tells RViz."""

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """The arm stands at q, shape (n_dof,)."""

    def draw_report(self, report: Report) -> None:
        """The light, its word, and the boxes that touch."""


class Show:
    """One demo on one screen. Every method may be called from any thread.

    Attributes:
        q: Where the arm stands, shape (n_dof,).
        time: How much of the trajectory was played [s].
        answer_time: From the last drag to the end of drawing its answer [s].
        lock: Held while drawing; hold it to do two things as one.
    """

    def __init__(self, demo: Demo, screen: Screen) -> None:
        self.demo, self.screen = demo, screen
        self.q = demo.robot.home
        self.time = self.answer_time = 0.0
        self.lock = threading.RLock()

    def stand(self, q: NDArray[np.float64]) -> None:
        """Put the arm at q."""
        with self.lock:
            self.q = q
            self.screen.draw_arm(q)
            self._answer()

    def advance(self, seconds: float) -> None:
        """Play the trajectory on."""
        with self.lock:
            self.time += seconds
            self.stand(self.demo.trajectory.at(self.time))

    def drag(self, T_base_box: ArrayLike) -> None:
        """Put the box at a pose, shape (4, 4), and answer at once."""
        start = time.perf_counter()
        with self.lock:
            self.demo.move_box(T_base_box)
            self._answer()
            self.answer_time = time.perf_counter() - start

    def _answer(self) -> None:
        self.screen.draw_report(self.demo.check(self.q))
