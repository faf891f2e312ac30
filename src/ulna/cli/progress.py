"""Shows how far a long command is, and how fast it is."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text


class _Rate(ProgressColumn):
    """Poses, or what they are, a second."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        super().__init__()

    def render(self, task: Task) -> Text:
        """As text."""
        return Text(f"{task.speed:,.0f} {self._unit}/s" if task.speed else "")


def progress_bar(*columns: ProgressColumn) -> Progress:
    """A bar on standard error if that is a terminal, nothing elsewhere."""
    console = Console(stderr=True)
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal, speed_estimate_period=120.0)


@contextmanager
def progress(name: str, unit: str = "poses") -> Iterator[Callable[[int, int], None]]:
    """What is called with the poses done, or other units, and those of all: a bar on a terminal, nothing elsewhere."""
    columns = TextColumn(name), BarColumn(), TextColumn("{task.percentage:.1f} %"), _Rate(unit), TimeRemainingColumn()
    with progress_bar(*columns) as bar:
        task = bar.add_task(name, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
    sys.stderr.flush()
