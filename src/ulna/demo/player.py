"""Plays the demo on a screen: moves the arm along its trajectory, and the box as the user drags it."""

import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.demo.around import BoxAvoidance, corners_of
from ulna.demo.scenario import Demo
from ulna.viewer.session.session import ask_at_once

_COLLISIONS, _TRAJECTORY = "what the box touches", "the trajectory"  # names on the page during their compilation


class Screen(Protocol):
    """The interface that draws the demo: the page, or a ROS node."""

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Draw the arm at q, shape (n_dof,)."""

    def draw_report(self, report: Report | None) -> None:
        """Draw the light, its text, and the boxes in contact; gray while the report is unknown."""


class Player:
    """One demo on one screen. Every method may be called from any thread.

    Args:
        demo: The demo.
        screen: Draws it.
        ask: Calls functions by ``Compiler.ask``, which returns None while another thread compiles their kernels. Until then the
            arm stands still, or the report is unknown.

    Attributes:
        report: The arm's boxes that touch the movable box; None while unknown.
        q: Joint positions of the arm [rad], shape (n_dof,).
        time: The time of the trajectory [s].
        avoiding: Whether the arm follows plans around the box, between the corners of its trajectory.
        around: Plans them.
        response_time: The time from the last drag to the end of drawing its result [s].
        lock: Held while drawing; hold it to make several changes at once.
    """

    def __init__(self, demo: Demo, screen: Screen, ask: Callable[..., Any] = ask_at_once) -> None:
        self.demo, self.screen, self._ask = demo, screen, ask
        self.report: Report | None = None
        self.q = demo.robot.home
        self.time = self.response_time = 0.0
        self.avoiding, self.around = False, BoxAvoidance(demo, ask)
        self.lock = threading.RLock()

    def move_to(self, q: NDArray[np.float64]) -> None:
        """Move the arm to q, shape (n_dof,)."""
        with self.lock:
            self.q = q
            self.around.remember(q)
            self.screen.draw_arm(q)
            self.check()

    def advance(self, seconds: float) -> None:
        """Advance by a time [s] along the trajectory, or along the plan around the box."""
        with self.lock:
            trajectory = self._ask(_TRAJECTORY, lambda: self.demo.trajectory)
            if trajectory is None:
                self.move_to(self.q)
            elif self.avoiding:
                self.move_to(self.around.advance(self.q, seconds, corners_of(trajectory.samples)))
            else:
                self.time += seconds
                self.move_to(trajectory.at(self.time))

    def drag(self, T_base_box: ArrayLike) -> None:
        """Move the box to a pose, shape (4, 4), check its contacts, and draw them at once."""
        start = time.perf_counter()
        with self.lock:
            self.demo.move_box(T_base_box)
            self.check()
            self.response_time = time.perf_counter() - start

    def check(self) -> None:
        """Check the contacts of the box again, and draw them."""
        with self.lock:
            self.report = self._ask(_COLLISIONS, self.demo.check, self.q)
            self.screen.draw_report(self.report)
