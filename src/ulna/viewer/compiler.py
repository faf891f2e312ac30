"""Compiles kernels in another thread, since a frame would otherwise wait up to half a minute for them."""

import threading
import time
import traceback
from collections.abc import Callable, Iterator
from functools import partial
from typing import ParamSpec, TypeVar

import numpy as np

from ulna.collision.world import World
from ulna.description.pose import pose
from ulna.description.shapes import Sphere
from ulna.engine.decorators import NotCompiledError, compiling_if
from ulna.robot import Robot
from ulna.robot.hand_link import hand_link
from ulna.viewer.session.clearance import clearance
from ulna.viewer.session.ellipsoid import mobility
from ulna.viewer.session.hand import Hand
from ulna.viewer.session.loads import TORQUES, has_inertias, loads

_P = ParamSpec("_P")
_R = TypeVar("_R")


class Compiler:
    """Calls functions whose kernels may have to be compiled first. Every method may be called from any thread.

    Args:
        wake: Called when a compilation has ended, after which ``ask`` can be called again.
    """

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._jobs: dict[str, Callable[[], object]] = {}  # the waiting jobs by name, in their order
        self._doing: str | None = None
        self._failed: set[str] = set()
        self._thread: threading.Thread | None = None
        self._since: float | None = None  # when the first job began
        self._stopping = self._news = False

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the running job and of the waiting ones."""
        with self._lock:
            return (*filter(None, [self._doing]), *(name for name in self._jobs if name != self._doing))

    @property
    def busy_for(self) -> float:
        """The time since it began to compile [s]; 0 if it does not."""
        since = self._since
        return 0.0 if since is None else time.monotonic() - since

    def ask(self, name: str, question: Callable[_P, _R], *arguments: _P.args, **options: _P.kwargs) -> _R | None:
        """Call a function; None while the other thread compiles a kernel that it needs.

        Args:
            name: A name of the call, which the page shows. Calls of one name are made one after the other.
            question: The function. The other thread calls it too, so it must have no side effects.
            arguments: Its arguments.
            options: Its keyword arguments.
        """
        if name in self.names:
            return None
        if name not in self._failed:
            try:
                with compiling_if(lambda: False):
                    return question(*arguments, **options)
            except NotCompiledError:
                self._add(name, partial(question, *arguments, **options), first=True)
                return None
        self._failed.discard(name)  # it failed in the other thread; here the caller gets the exception
        return question(*arguments, **options)

    def prepare(self, name: str, job: Callable[[], object]) -> None:
        """Compile the kernels of a job by running it in the other thread, after all others."""
        self._add(name, job, first=False)

    def pop_finished(self) -> bool:
        """Whether a job has ended since the last call."""
        news, self._news = self._news, False
        return news

    def stop(self, within: float) -> None:
        """Start no more compilations, and wait at most ``within`` seconds for the running one."""
        with self._lock:
            self._stopping = True
            self._jobs.clear()
            thread = self._thread
        if thread is not None:
            thread.join(within)

    @property
    def ended(self) -> bool:
        """Whether nothing is being compiled."""
        thread = self._thread
        return thread is None or not thread.is_alive()

    def _add(self, name: str, job: Callable[[], object], *, first: bool) -> None:
        with self._lock:
            if not self._may_go_on():
                return
            self._jobs = {name: job, **self._jobs} if first else {**self._jobs, name: job}
            if self._thread is None:  # not a daemon: a program that exits while a daemon thread compiles aborts
                self._since = time.monotonic()
                self._thread = threading.Thread(target=self._run, name="ulna-compiler", daemon=False)
                self._thread.start()

    def _run(self) -> None:
        while (job := self._next()) is not None:
            try:
                with compiling_if(self._may_go_on):
                    job()
            except NotCompiledError:
                pass  # ``stop`` was called
            except Exception:  # noqa: BLE001 - logged here, and raised by the next call of ``ask``
                traceback.print_exc()
                self._failed.add(self._doing or "")
            with self._lock:
                self._doing, self._news = None, True
            self._wake()

    def _next(self) -> Callable[[], object] | None:
        with self._lock:
            if not self._jobs or not self._may_go_on():
                self._jobs.clear()
                self._thread = self._since = None
                return None
            self._doing = next(iter(self._jobs))
            return self._jobs.pop(self._doing)

    def _may_go_on(self) -> bool:
        return not self._stopping and threading.main_thread().is_alive()


_FAR = 90.0  # [m] out of reach, yet no likely millimeters: finding the reason for that has kernels of its own


def rehearsals(robot: Robot, *, checked: bool) -> Iterator[tuple[str, Callable[[], object]]]:
    """The calls, each with a name that the page shows; those that are needed first come first."""
    world = World()
    world.add("ball", Sphere(1.0), pose((_FAR, 0.0, 0.0)))
    if robot.n_dof:
        yield "dragging the hand", lambda: _drag(robot, None)
        if has_inertias(robot):
            yield TORQUES, lambda: loads(robot, robot.home)
        yield "the manipulability of the hand", lambda: mobility(robot, robot.home, hand_link(robot))
    if checked:
        yield "distances between shapes", lambda: clearance(robot, robot.home, world)
    if checked and robot.n_dof:
        yield "dragging the hand around obstacles", lambda: _drag(robot, world)


def _drag(robot: Robot, world: World | None) -> None:
    """Drag the hand to its own pose, to one nearby, and to one out of reach."""
    hand = Hand(robot, hand_link(robot))
    for step in (0.0, 0.01, _FAR):
        T = robot.forward_kinematics(robot.home, link=hand.link).copy()
        T[:3, 3] += np.array((step, 0.0, 0.0))
        hand.follow(robot.home, T, world)
