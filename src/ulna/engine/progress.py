"""Draws the progress of a long call on a terminal's standard error, by rich."""

import weakref
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn


_shown: "weakref.WeakSet[Progress]" = weakref.WeakSet()


def is_bar_shown() -> bool:
    """Whether a bar is drawn now."""
    return any(bar.live.is_started for bar in _shown)


def progress_bar(*columns: "ProgressColumn") -> "Progress":
    """A bar on standard error if that is a terminal, nothing elsewhere."""
    from rich.console import Console  # noqa: PLC0415 - few calls take long, and rich takes long to import
    from rich.progress import Progress  # noqa: PLC0415

    console = Console(stderr=True)
    console.quiet = not console.is_terminal  # rich before 14.3 ends a disabled bar with an empty line
    bar = Progress(*columns, console=console, transient=True, disable=console.quiet, speed_estimate_period=120.0)
    _shown.add(bar)
    return bar
