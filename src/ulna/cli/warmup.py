"""``ulna warmup``: compiles all code that is otherwise compiled on first use."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import typer
from rich.console import RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.text import Text

from ulna.cli.depends import Json, command
from ulna.cli.output import Data, Output, make_table
from ulna.engine.ahead import FOLDER, is_ahead
from ulna.engine.entries import Entries
from ulna.engine.progress import progress_bar
from ulna.engine.threads import n_threads
from ulna.errors import FileError

if TYPE_CHECKING:
    from ulna.engine.warmup import Compiled  # imports the compiler

WARMUP_KEYS = (
    "folder: of the machine code; seconds: in total; compiled: entry, shapes (boxes or any, where that is two), seconds, "
    "was_cached: it was there already."
)


@command
def warmup(*, as_json: Json = False) -> Output:
    """Compile every kernel for this machine, so that no first call waits for it.

    The machine code is kept on disk: a second run takes seconds. NUMBA_CACHE_DIR sets the folder, as for Numba itself.
    """
    if is_ahead():  # the wheel contains all machine code
        return Output(warmup_data(str(FOLDER), 0.0, []), warmup_table)
    from ulna.engine.cache import cache_folder  # noqa: PLC0415 -- it loads the compiler, which other commands may not need
    from ulna.engine.warmup import all_jobs, compile_all  # noqa: PLC0415

    folder = cache_folder()
    if folder is None:
        reason = "it cannot be written, or other users can write to it, so nothing would be stored"
        raise FileError("cache folder", f"{reason}; NUMBA_CACHE_DIR names another")
    jobs, start = all_jobs(Entries("ulna")), time.perf_counter()
    compiled = with_progress(compile_all(jobs, side_by_side=n_threads() > 1), len(jobs), in_lines=not as_json)
    return Output(warmup_data(str(folder.path), time.perf_counter() - start, compiled), warmup_table)


def with_progress(compiled: Iterable[Compiled], total: int, *, in_lines: bool) -> list[Compiled]:
    """List ``compiled``, with progress on standard error: a bar on a terminal, else lines if ``in_lines``."""
    columns = TextColumn("compiling"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}")
    done = []
    with progress_bar(*columns) as bar:
        task = bar.add_task("", total=total)
        for one in compiled:
            done.append(one)
            bar.update(task, advance=1, description=one.name)
            if bar.disable and in_lines:
                typer.echo(f"ulna: {len(done)} of {total}: {_named(one.name, one.shapes)}, {one.seconds:.1f} s", err=True)
    return done


def warmup_data(folder: str, seconds: float, compiled: Iterable[Compiled]) -> Data:
    """Collect the compilation time of each entry, longest first; see ``WARMUP_KEYS``."""
    rows = [
        {"entry": one.name, "shapes": one.shapes, "seconds": one.seconds, "was_cached": one.was_cached}
        for one in sorted(compiled, key=lambda one: -one.seconds)
    ]
    return {"folder": folder, "seconds": seconds, "compiled": rows}


def warmup_table(data) -> Iterator[RenderableType]:
    """Show the time of each compiled entry, and the folder of the machine code."""
    table = make_table(["compiled"], ["seconds"], [])
    for row in data["compiled"]:
        if not row["was_cached"]:
            table.add_row(_named(row["entry"], row["shapes"]), f"{row['seconds']:.1f}")
    if table.row_count:
        yield table
    yield Text(f"{table.row_count} of {len(data['compiled'])} compiled in {data['seconds']:.1f} s; the others were cached")
    yield Text(f"machine code: {data['folder']}", no_wrap=True)


def _named(entry: str, shapes: str) -> str:
    return f"{entry} ({shapes} shapes)".replace("(boxes shapes)", "(boxes)") if shapes else entry
