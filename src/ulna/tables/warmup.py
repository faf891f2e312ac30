"""``ulna warmup`` for people: how far it is, and what it did."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import typer
from rich.console import Console, RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from ulna.tables.writing import make_table

if TYPE_CHECKING:
    from ulna.warmup import Compiled  # which loads the compiler


def with_progress(compiled: Iterable[Compiled], total: int, *, in_lines: bool) -> list[Compiled]:
    """All that is compiled, told on standard error while it goes on: a bar on a terminal, elsewhere a line each, if wanted."""
    if sys.stderr.isatty():
        columns = (
            TextColumn("compiling"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.description}"),
        )
        with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task("", total=total)
            done = []
            for one in compiled:
                done.append(one)
                progress.update(task, advance=1, description=one.name)
            return done
    done = []
    for one in compiled:
        done.append(one)
        if in_lines:
            typer.echo(f"ulna: {len(done)} of {total}: {_named(one.name, one.shapes)}, {one.seconds:.1f} s", err=True)
    return done


def warmup_view(data) -> Iterator[RenderableType]:
    """What took how long, and where it lies."""
    table = make_table(["compiled"], ["seconds"], [])
    for row in data["compiled"]:
        if not row["was_cached"]:
            table.add_row(_named(row["entry"], row["shapes"]), f"{row['seconds']:.1f}")
    if table.row_count:
        yield table
    yield Text(f"{table.row_count} of {len(data['compiled'])} compiled in {data['seconds']:.1f} s; the others were there already")
    yield Text(f"machine code: {data['folder']}", no_wrap=True)


def _named(entry: str, shapes: str) -> str:
    return f"{entry} ({shapes} shapes)".replace("(boxes shapes)", "(boxes)") if shapes else entry
