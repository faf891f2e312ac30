"""Imports the modules ``ros1`` and ``ros2``, and ends their ROS nodes cleanly.

Both modules need ROS. If the import fails, the error names the missing part and a command that works without ROS.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from ulna.cli.quiet_imports import quiet_imports
from ulna.errors import MissingROSError, UlnaError

if TYPE_CHECKING:
    from ulna.viewer.compiler import Compiler

_CTRL_C = 130


def exit_quietly(number: int, _frame: object) -> None:
    """Handle a signal by an exit without a traceback, which closes every context."""
    sys.exit(128 + number)


def noted_signals() -> list[int]:
    """Install handlers of SIGINT and SIGTERM that append to the returned list; a second signal raises SystemExit.

    The handlers of rospy and rclpy end the node from another thread or in the middle of a step. The handler of rospy waits
    forever for a lock that this thread holds, as in ``publish()``; after the handler of rclpy the next call raises. These
    handlers need no lock: the node ends between two steps.
    """
    come: list[int] = []

    def note(number: int, _frame: object) -> None:
        signal.signal(number, exit_quietly)
        come.append(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, note)
    return come


@contextmanager
def node_compiler() -> Iterator[Compiler]:
    """A context with a compiler. It must be the outermost one of a program, since it may end the process.

    If the block ends while something is being compiled, the process ends at once. A normal exit would wait for the compilation,
    up to half a minute.
    """
    from ulna.viewer.compiler import Compiler  # noqa: PLC0415 -- it imports Numba, which the help of a command does not need

    compiler, status = Compiler(lambda: None), None
    try:
        yield compiler
        status = 0
    except (KeyboardInterrupt, SystemExit):
        status = _CTRL_C
        raise
    finally:
        compiler.stop(0.0)
        if status is not None and not compiler.ended:
            sys.stdout.flush()
            os._exit(status)


# The variable that restricts ROS to this machine, and the variables with which a user may have chosen otherwise.
_LOCAL = {1: ("ROS_IP", "127.0.0.1"), 2: ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")}
_SAID = {1: ("ROS_IP", "ROS_HOSTNAME"), 2: ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS")}


def load_ros(version: int, module: str | None = None, without: str = "ulna demo") -> ModuleType:
    """Import a module of ``ulna.demo.ros``, by default ``ros1`` or ``ros2``; keeps ROS local unless its variables are set.

    Raises:
        MissingROSError: ROS is not installed; the message names a command that works ``without`` it.
    """
    if not any(os.environ.get(name) for name in _SAID[version]):
        name, value = _LOCAL[version]
        os.environ[name] = value
    try:
        return import_module(f"ulna.demo.ros.{module or f'ros{version}'}")
    except ImportError as error:  # before its setup script has run, modules of ROS fail in other ways too
        if isinstance(error, UlnaError) or (error.name or "").startswith("ulna"):
            raise
        lacks = isinstance(error, ModuleNotFoundError)
        reason = (
            f"this Python has no module {error.name!r}" if lacks else f"it cannot be imported: {' '.join(str(error).split())}"
        )
        raise MissingROSError(
            f"ROS {version} is not available ({reason}; docs/ros.md explains its installation); "
            f"the same in the browser, without ROS: {without}"
        ) from None


def ros1_or_exit() -> ModuleType:
    """Return ``load_ros(1)`` for a script, or exit with the message without ROS. From then on Ctrl-C prints no traceback."""
    try:
        with quiet_imports():
            ros = load_ros(1)
    except MissingROSError as error:
        sys.exit(str(error))
    signal.signal(signal.SIGINT, exit_quietly)
    return ros
