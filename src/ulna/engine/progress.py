"""Draws how far a long call is, by rich: on a terminal, on standard error."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn


def progress_bar(*columns: "ProgressColumn") -> "Progress":
    """A bar on standard error if that is a terminal, nothing elsewhere."""
    from rich.console import Console  # noqa: PLC0415 - few calls take long, and rich takes long to import
    from rich.progress import Progress  # noqa: PLC0415

    console = Console(stderr=True)
    console.quiet = not console.is_terminal  # rich before 14.3 ends a disabled bar with an empty line
    return Progress(*columns, console=console, transient=True, disable=console.quiet, speed_estimate_period=120.0)
