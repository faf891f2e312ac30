"""Plans many motions in several threads. Used by ``Robot.plan_many``."""

import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.engine.threads import in_rows
from ulna.errors import InputError
from ulna.planning.plan import Plan
from ulna.planning.slices import stopping

Array = NDArray[np.float64]


def plan_many(
    plan: Callable[[Any, Any, World | None], Plan],
    q_starts: ArrayLike,
    goals: ArrayLike | Mapping[str, ArrayLike],
    worlds: World | Iterable[World | None] | None,
    threads: int | None,
    *,
    progress: Callable[[int, int], None] | bool | None,
) -> tuple[Plan, ...]:
    """A plan for each problem, in their order; see ``Robot.plan_many``.

    Raises:
        InputError: The numbers of starts, goals and worlds do not go together, or a row is refused; the message names the row.
    """
    starts, targets = as_floats("q_starts", q_starts), _rows(goals)
    if starts.ndim not in {1, 2}:
        raise InputError("q_starts", f"shape {starts.shape}; configurations, shape (n, n_dof) or (n_dof,), are expected")
    many = [worlds] if worlds is None or isinstance(worlds, World) else list(worlds)
    counts = {len(targets)} | ({len(starts)} if starts.ndim == 2 else set()) | ({len(many)} if len(many) != 1 else set())
    if len(counts) > 1:
        n_starts = len(starts) if starts.ndim == 2 else 1
        raise InputError("goals", f"{len(targets)} goals, {n_starts} starts and {len(many)} worlds do not go together")
    if progress is True:
        from ulna.engine.progress import progress as bar  # noqa: PLC0415 - rich is needed for nothing else

        with bar("planning", "plans") as shown:
            return _planned(plan, starts, targets, many, threads, shown)
    return _planned(plan, starts, targets, many, threads, progress or None)


def _planned(
    plan: Callable[[Any, Any, World | None], Plan],
    starts: Array,
    targets: list[Any],
    many: list[World | None],
    threads: int | None,
    progress: Callable[[int, int], None] | None,
) -> tuple[Plan, ...]:
    plans: list[Any] = [None] * len(targets)
    stopped, lock = threading.Event(), threading.Lock()
    done = 0

    def run(i: int) -> bool:
        nonlocal done
        start, world = starts if starts.ndim == 1 else starts[i], many[0] if len(many) == 1 else many[i]
        try:
            with stopping(stopped):
                plans[i] = plan(np.array(start), targets[i], world)
        except InputError as error:
            raise InputError(f"row {i}: {error.argument}", error.message) from None
        with lock:
            done += 1
            if progress is not None:
                progress(done, len(plans))
        return True

    in_rows(run, len(plans), threads, stopped.set)
    return tuple(plans)


def _rows(goals: ArrayLike | Mapping[str, ArrayLike]) -> list[Any]:
    """The goals, one a problem.

    Raises:
        InputError: They are not rows of configurations or poses; or there are not as many poses of each link.
    """
    if isinstance(goals, Mapping):
        of_links = {link: as_floats("goals", poses) for link, poses in goals.items()}
        shapes = {poses.shape for poses in of_links.values()}
        if len(shapes) != 1 or len(shape := shapes.pop()) != 3:
            raise InputError("goals", "poses of as many problems are expected for each link, shape (n, 4, 4)")
        return [{link: poses[i].copy() for link, poses in of_links.items()} for i in range(shape[0])]
    rows = as_floats("goals", goals)
    if rows.ndim not in {2, 3}:
        raise InputError("goals", f"shape {rows.shape}; shape (n, n_dof), or (n, 4, 4) for poses, is expected: a goal a row")
    return [np.array(row) for row in rows]
