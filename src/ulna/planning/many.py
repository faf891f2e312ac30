"""Plans many motions in several threads. Used by ``Robot.plan_many``."""

import threading
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.engine.threads import in_rows
from ulna.errors import InputError
from ulna.planning.plan import Plan
from ulna.planning.slices import stopping


def plan_many(
    plan: Callable[[Any, Any, World | None], Plan],
    q_starts: ArrayLike,
    goals: ArrayLike,
    worlds: World | Iterable[World | None] | None,
    threads: int | None,
    progress: Callable[[int, int], None] | None,
) -> tuple[Plan, ...]:
    """A plan for each problem, in their order; see ``Robot.plan_many``.

    Raises:
        InputError: The numbers of starts, goals and worlds do not go together, or a row is refused; the message names the row.
    """
    starts, targets = as_floats("q_starts", q_starts), as_floats("goals", goals)
    if starts.ndim not in {1, 2}:
        raise InputError("q_starts", f"shape {starts.shape}; configurations, shape (n, n_dof) or (n_dof,), are expected")
    if targets.ndim not in {2, 3}:
        raise InputError("goals", f"shape {targets.shape}; shape (n, n_dof), or (n, 4, 4) for poses, is expected: a goal a row")
    many = [worlds] if worlds is None or isinstance(worlds, World) else list(worlds)
    counts = {len(targets)} | ({len(starts)} if starts.ndim == 2 else set()) | ({len(many)} if len(many) != 1 else set())
    if len(counts) > 1:
        n_starts = len(starts) if starts.ndim == 2 else 1
        raise InputError("goals", f"{len(targets)} goals, {n_starts} starts and {len(many)} worlds do not go together")
    plans: list[Any] = [None] * len(targets)
    stopped = threading.Event()
    done = 0

    def run(i: int) -> bool:
        nonlocal done
        start, world = starts if starts.ndim == 1 else starts[i], many[0] if len(many) == 1 else many[i]
        try:
            with stopping(stopped):
                plans[i] = plan(np.array(start), np.array(targets[i]), world)
        except InputError as error:
            raise InputError(f"row {i}: {error.argument}", error.message) from None
        done += 1
        if progress is not None:
            progress(done, len(plans))
        return True

    in_rows(run, len(plans), threads, stopped.set)
    return tuple(plans)
