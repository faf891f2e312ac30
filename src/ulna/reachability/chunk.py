"""Computes chunks of a map and writes them: the code of a thread or of a cluster's worker.

A chunk depends only on the map's attributes and on its own number. It has the same bits on every worker, so two workers may
compute it without harm.
"""

from __future__ import annotations

import math
import os
import threading
import time
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.scene_file import world_from_json
from ulna.collision.world import World
from ulna.engine.threads import VARIABLE, default_threads, threads
from ulna.errors import FileError
from ulna.reachability.model import robot_from_json
from ulna.reachability.specification import Specification
from ulna.reachability.store import has_chunk, metadata_bytes, open_arrays, read_specification, variables
from ulna.reachability.verdicts import REACHED, verdicts
from ulna.robot import Robot

Array = NDArray[np.float64]
_MAX_OPEN = 4  # maps that a process keeps open


class Outcome(NamedTuple):
    """The outcome of a task: the poses in its chunks, and its time in seconds."""

    poses: int
    seconds: float


@dataclass(frozen=True, eq=False)
class OpenMap:
    """A map under computation: its specification, its robot, its world, and its arrays."""

    path: Path
    specification: Specification
    robot: Robot
    world: World | None
    arrays: dict[str, Any]


def run_on_worker(path: str, chunks: tuple[int, ...]) -> Outcome:
    """``run_task`` on a worker of a cluster, in ``ULNA_THREADS`` threads if the worker sets it, else in one.

    A worker runs one task on each of its threads.
    """
    with threads(default_threads() if os.environ.get(VARIABLE, "").strip() else 1):
        return run_task(path, chunks)


def run_task(path: str, chunks: tuple[int, ...], stop: threading.Event | None = None) -> Outcome:
    """Compute and write the missing chunks, one after the other; ``stop`` ends the task after the current chunk."""
    start, poses = time.perf_counter(), 0
    opened = _open_map(path, metadata_bytes(Path(path)))
    grid = opened.specification.grid
    for chunk in chunks:
        if stop is not None and stop.is_set():
            break
        if not has_chunk(opened.path, grid.place(chunk)):
            write(opened, chunk, compute(opened, chunk))
        poses += grid.poses_of(chunk)
    return Outcome(poses, time.perf_counter() - start)


def compute(opened: OpenMap, chunk: int) -> dict[str, NDArray]:
    """The variables of a chunk by name, ``reached`` last; each of the chunk's own shape."""
    specification, robot = opened.specification, opened.robot
    region = specification.grid.region(chunk)
    shape = tuple(cut.stop - cut.start for cut in region)
    reached, every_q, known_solutions, branches = verdicts(specification, robot, opened.world, specification.grid.targets(region))
    solved = np.flatnonzero(reached == REACHED)
    q = every_q[solved]
    values: dict[str, NDArray] = {} if branches is None else {"branches": branches.reshape(shape)}
    for name in variables(specification)[len(values) : -1]:
        match name:
            case "manipulability":
                of_solved = robot.manipulability(q, link=specification.link)
            case "clearance":
                of_solved = robot.signed_distance(q, opened.world)
            case "payload":
                of_solved = _largest_payload(robot, specification.link, known_solutions, len(reached))[solved]
            case _:
                of_solved = q
        values[name] = _fill_unsolved(np.asarray(of_solved, dtype=np.float32), solved, shape)
    return {**values, "reached": reached.reshape(shape)}


def _largest_payload(robot: Robot, link: str, known: tuple[Array, NDArray[np.int64]], n: int) -> Array:
    """The largest payload over the known solutions of each of n poses [kg], shape (n,); 0 without a solution."""
    q, poses = known
    largest = np.zeros(n)
    np.maximum.at(largest, poses, robot.payload(q, link=link))
    return largest


def write(opened: OpenMap, chunk: int, values: dict[str, NDArray]) -> None:
    """Write a chunk, the verdict last."""
    region = opened.specification.grid.region(chunk)
    try:
        for name, array in values.items():
            opened.arrays[name][region] = array
    except OSError as error:
        raise FileError(str(opened.path), f"a chunk cannot be written ({error.strerror or error})") from None


def _fill_unsolved(of_solved: NDArray[np.float32], solved: NDArray[np.int64], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """The values at the solved poses, NaN at the others."""
    tail = of_solved.shape[1:]
    flat = np.full((math.prod(shape), *tail), np.nan, dtype=np.float32)
    flat[solved] = of_solved
    return flat.reshape(*shape, *tail)


@lru_cache(maxsize=_MAX_OPEN)
def _open_map(path: str, metadata: bytes) -> OpenMap:  # noqa: ARG001 -- another map at the same path has other metadata
    where = Path(path)
    specification = read_specification(where)
    if specification.version != version("ulna"):
        raise FileError(
            path, f"the map is from Ulna {specification.version}, but this is {version('ulna')}, which gives other bits"
        )
    world = None if specification.scene is None else world_from_json(specification.scene, "the map's scene")
    robot = robot_from_json(specification.model)
    arrays = open_arrays(where, specification, robot.n_dof, mode="r+")
    return OpenMap(where, specification, robot, world, arrays)
