"""Shows how far a long command is, and how fast it is. Used by ``ulna reach``."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text


class _Rate(ProgressColumn):
    """Poses a second."""

    def render(self, task: Task) -> Text:
        """As text."""
        return Text(f"{task.speed:,.0f} poses/s" if task.speed else "")


@contextmanager
def progress(name: str) -> Iterator[Callable[[int, int], object]]:
    """What is called with the poses done and those of all: a bar on a terminal, nothing elsewhere."""
    console = Console(stderr=True)
    columns = TextColumn(name), BarColumn(), TextColumn("{task.percentage:.1f} %"), _Rate(), TimeRemainingColumn()
    bar = Progress(*columns, console=console, transient=True, speed_estimate_period=120.0)
    with bar if console.is_terminal else nullcontext():
        task = bar.add_task(name, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
    sys.stderr.flush()
