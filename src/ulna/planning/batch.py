"""Plans many problems in several threads."""

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.engine.progress import progress_bar
from ulna.engine.threads import in_rows
from ulna.errors import InputError, UnknownNameError, count_of
from ulna.planning.plan import Plan
from ulna.planning.slices import stopping

Array = NDArray[np.float64]


def plan_many(
    plan: Callable[[Any, Any, World | None], Plan],
    q_starts: ArrayLike | str | Sequence[str],
    goals: ArrayLike | Mapping[str, ArrayLike] | str | Sequence[str],
    world: World | Iterable[World | None] | None,
    *,
    progress: Callable[[int, int], None] | bool | None,
    plan_together: Callable[[list[Any], list[Any]], list[Plan | None]] | None = None,
) -> tuple[Plan, ...]:
    """Plan each problem, and return the plans in order; see ``Robot.plan_many``.

    plan_together: Plans some of the problems in one call, from all starts and all goals; None for each of the others.
    """
    many = [world] if world is None or isinstance(world, World) else list(world)
    starts, each = _starts(q_starts)
    counts = ({len(starts)} if each else set()) | ({len(many)} if len(many) != 1 else set())
    targets = [goals] * max(counts, default=1) if isinstance(goals, str) else _rows(goals)
    if len(counts | {len(targets)}) > 1:
        given = count_of(len(targets), "goal"), count_of(len(starts), "start"), count_of(len(many), "world")
        raise InputError("goals", f"{given[0]}, {given[1]} and {given[2]} do not go together")
    starts = starts if each else starts * len(targets)
    known = [None] * len(targets) if plan_together is None else plan_together(starts, targets)
    with _progress() if progress is True else nullcontext(progress or None) as shown:
        return _run_all(plan, list(zip(starts, targets, known, strict=True)), many, shown)


def _run_all(
    plan: Callable[[Any, Any, World | None], Plan],
    problems: list[tuple[Any, Any, Plan | None]],
    many: list[World | None],
    progress: Callable[[int, int], None] | None,
) -> tuple[Plan, ...]:
    plans: list[Any] = [None] * len(problems)
    stopped, lock = threading.Event(), threading.Lock()
    done = 0

    def run(i: int) -> bool:
        nonlocal done
        try:
            with stopping(stopped):
                start, target, known = problems[i]
                plans[i] = known or plan(start, target, many[0] if len(many) == 1 else many[i])
        except InputError as error:
            raise InputError(f"row {i}: {error.argument}", error.message) from None
        except UnknownNameError as error:
            error.add_note(f"row {i}")
            raise
        with lock:
            done += 1
            if progress is not None:
                progress(done, len(plans))
        return True

    in_rows(run, len(plans), stopped.set)
    return tuple(plans)


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """A progress function of the numbers of finished and all plans, which draws a bar on a terminal."""
    from rich.progress import Progress, TextColumn  # noqa: PLC0415 - it takes long to import

    with progress_bar(*Progress.get_default_columns(), TextColumn("{task.fields[rate]}")) as bar:
        task = bar.add_task("planning", total=None, rate="")

        def show(done: int, total: int) -> None:
            speed = bar.tasks[0].speed
            bar.update(task, completed=done, total=total, rate=f"{speed:,.0f} plans/s" if speed else "")

        yield show


def _starts(q_starts: ArrayLike | str | Sequence[str]) -> tuple[list[Any], bool]:
    """The starts, and whether there is one for each problem instead of one for all."""
    if isinstance(q_starts, str):
        return [q_starts], False
    if (names := _names(q_starts)) is not None:
        return names, True
    starts = as_floats("q_starts", q_starts)
    if starts.ndim not in {1, 2}:
        raise InputError("q_starts", f"shape {starts.shape}; configurations, shape (n, n_dof) or (n_dof,), are expected")
    return ([np.array(row) for row in starts], True) if starts.ndim == 2 else ([np.array(starts)], False)


def _names(rows: Any) -> list[Any] | None:
    """The names in a sequence of names; None for other data."""
    rows = rows.tolist() if isinstance(rows, np.ndarray) and rows.dtype.kind == "U" and rows.ndim == 1 else rows
    is_names = isinstance(rows, Sequence) and len(rows) > 0 and all(isinstance(row, str) for row in rows)
    return list(rows) if is_names else None


def _rows(goals: ArrayLike | Mapping[str, ArrayLike] | Sequence[str]) -> list[Any]:
    """The goals, one per problem."""
    if isinstance(goals, Mapping):
        of_links = {link: as_floats("goals", poses) for link, poses in goals.items()}
        shapes = {poses.shape for poses in of_links.values()}
        if len(shapes) != 1 or len(shape := shapes.pop()) != 3:
            raise InputError("goals", "poses of as many problems are expected for each link, shape (n, 4, 4)")
        return [{link: poses[i].copy() for link, poses in of_links.items()} for i in range(shape[0])]
    if (names := _names(goals)) is not None:
        return names
    rows = as_floats("goals", goals)
    if rows.ndim not in {2, 3}:
        raise InputError("goals", f"shape {rows.shape}; shape (n, n_dof), or (n, 4, 4) for poses, is expected: a goal a row")
    return [np.array(row) for row in rows]
