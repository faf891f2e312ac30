"""Ctrl-C and SIGTERM, noted until a node can end."""

import signal
import sys


def exit_quietly(number: int, _frame: object) -> None:
    """Handle a signal by an exit without a traceback, which closes every context.

    Raises:
        SystemExit: With the status that shells report of the signal.
    """
    sys.exit(128 + number)


def noted_signals() -> list[int]:
    """Install handlers of SIGINT and SIGTERM, and return the list to which they append. A second signal raises SystemExit.

    The handlers of rospy and rclpy end the node from another thread or in the middle of a step: rospy's waits forever for a lock
    that this thread holds, as in ``publish()``; after rclpy's the next call raises. These need no lock: the node ends between
    two steps.
    """
    come: list[int] = []

    def note(number: int, _frame: object) -> None:
        signal.signal(number, exit_quietly)
        come.append(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, note)
    return come
