"""What is asked of a search: targets, seeds, tolerances and budget, checked and in the shapes that the kernels take."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.errors import InputError, UnknownNameError
from ulna.ik.bounds import bounds_of
from ulna.ik.lengths import far_square
from ulna.ik.task import Task
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.positions import as_positions, refuse_out_of_range, rows_of
from ulna.kinematics.tree import Tree, lengthened

Array = NDArray[np.float64]
STEPS, SEEDED_STEPS = 20, 60  # from one start before the next; from the caller's own
DEFAULT_BUDGET = 16_000  # steps: 800 starts


@dataclass(frozen=True, eq=False)
class Problem:
    """A search for each of ``targets`` (n, 4, 4), of batch shape ``batch``.

    ``chain`` ends in the task's frame, ``targets`` are of that frame; seeds (n or 1, n_dof); bounds (n or 1, 4, n_dof) as in
    ``ik.bounds``, narrowed or not; posture (n_dof,), read if the kernels' ``settings`` say so.
    """

    tree: Tree
    chain: Array
    link: str
    targets: Array
    batch: tuple[int, ...]
    task: Task
    seeds: Array
    seeded: bool
    bounds: Array
    is_narrowed: bool
    posture: Array
    settings: Array
    tolerances: tuple[float, float]
    seed: int
    max_step: float
    budget: int
    time_limit: float
    threads: int | None
    nearest_to: Array | None = None
    """Of what is equally good by whole turns the nearest to these (n or 1, n_dof) is wanted."""


def make_problem(
    tree: Tree,
    T: ArrayLike,
    link: str,
    home: Array,
    *,
    q_seed: ArrayLike | None,
    task: Task,
    posture: ArrayLike | str | None,
    held: Iterable[str],
    max_step: float | None,
    tolerances: tuple[float, float],
    seed: int,
    budget: int,
    time_limit: float | None,
    threads: int | None,
) -> Problem:
    """Check the arguments of a search. Whether targets are rigid motions the kernels see, at no cost."""
    refuse_immovable(tree)
    targets = _targets(T)
    batch = targets.shape[:-2]
    seeds = home.copy().reshape(1, -1) if q_seed is None else _seeds(tree, q_seed, batch)
    chain, settings = tree.chain(link), np.zeros(layout.N_SETTINGS)
    settings[layout.POSITION_TOLERANCE], settings[layout.ROTATION_TOLERANCE] = (
        positive("position_tolerance", tolerances[0]),
        positive("rotation_tolerance", tolerances[1]),
    )
    settings[layout.STEPS], settings[layout.TASK], settings[layout.FAR] = STEPS, task.kind, far_square(tree, link)
    settings[layout.SLACK : layout.SLACK + 6] = task.slack
    settings[layout.WITH_POSTURE] = posture is not None
    if max_step is not None and q_seed is None:
        raise InputError("max_step", "bounds the way from q_seed, so q_seed is needed too")
    step = np.inf if max_step is None else positive("max_step", max_step)
    columns = _columns(tree, held)
    chain, targets = _in_task_frame(chain, targets.reshape(-1, 4, 4), task.turn)
    return Problem(
        tree=tree,
        chain=chain,
        link=link,
        targets=targets,
        batch=batch,
        task=task,
        seeds=np.clip(seeds, tree.lower, tree.upper),
        seeded=q_seed is not None,
        bounds=bounds_of(tree, seeds, columns, step),
        is_narrowed=bool(columns) or np.isfinite(step),
        max_step=step,
        posture=home.copy() if posture is None else _posture(tree, posture),
        settings=settings,
        tolerances=tolerances,
        seed=as_count("seed", seed),
        budget=as_count("max_iterations", budget),
        time_limit=np.inf if time_limit is None else _at_least_zero("time_limit", time_limit),
        threads=None if threads is None else as_count("threads", threads),
    )


def refuse_immovable(tree: Tree) -> None:
    """An ``InputError`` for a robot without joints."""
    if not tree.n_dof:
        raise InputError("T", "the robot has no moving joints, so nothing can be solved for")


def _targets(T: ArrayLike) -> Array:
    targets = as_floats("T", T)
    if targets.shape[-2:] != (4, 4):
        raise InputError("T", f"shape {targets.shape}, but targets have shape (..., 4, 4); ulna.pose(xyz, rpy) makes one")
    return targets


def refuse_what_is_no_pose(T: ArrayLike) -> None:
    """Raise the ``InputError`` that says which target is no rigid motion."""
    as_pose(as_floats("T", T))


def _in_task_frame(chain: Array, targets: Array, turn: Array | None) -> tuple[Array, Array]:
    """The chain and its targets with the end's axes turned: R_end_task = turn."""
    if turn is None:
        return chain, targets
    T_end_task = np.eye(4)
    T_end_task[:3, :3] = turn
    return lengthened(chain, T_end_task), targets @ T_end_task


def _columns(tree: Tree, held: Iterable[str]) -> tuple[int, ...]:
    """The entries of q that belong to the joints that are held."""
    columns: list[int] = []
    if not isinstance(held, Iterable):
        raise InputError("held", f"{held!r}; names of joints are expected")
    for name in [held] if isinstance(held, str) else held:
        if name not in tree.joint_names:
            raise UnknownNameError("joint", str(name), tree.joint_names)
        columns += range(tree.n_dof)[tree.joint_slices[tree.joint_names.index(name)]]
    return tuple(columns)


def _seeds(tree: Tree, q_seed: ArrayLike, batch: tuple[int, ...]) -> Array:
    """One seed for all targets or one for each."""
    seeds = as_positions(q_seed, tree, "q_seed")
    refuse_out_of_range(seeds, "q_seed")
    if seeds.ndim == 1:
        return seeds.reshape(1, -1)
    try:
        return rows_of(seeds, batch)
    except ValueError:
        message = f"shape {seeds.shape} does not go with targets of batch shape {batch}: give one seed, or one for each target"
        raise InputError("q_seed", message) from None


def mid_range(tree: Tree) -> Array:
    """The middle of every joint's range; 0, or the nearest to it, where there is none."""
    bounded = np.isfinite(tree.lower) & np.isfinite(tree.upper)
    with np.errstate(invalid="ignore"):
        middle = np.where(bounded, (tree.lower + tree.upper) / 2, 0.0)
    return np.clip(middle, tree.lower, tree.upper)


def _posture(tree: Tree, posture: ArrayLike | str) -> Array:
    if isinstance(posture, str):
        if posture != "mid_range":
            raise InputError("posture", f"{posture!r}; a configuration or 'mid_range' is expected")
        return mid_range(tree)
    goal = as_positions(posture, tree, "posture")
    if goal.ndim != 1:
        raise InputError("posture", f"shape {goal.shape}, but one posture, shape ({tree.n_dof},), serves all targets")
    refuse_out_of_range(goal, "posture")
    return np.clip(goal, tree.lower, tree.upper)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def positive(name: str, value: float) -> float:
    """A finite number above 0, or an ``InputError`` that names it."""
    if not _is_number(value) or not 0 < value < np.inf:
        raise InputError(name, f"{value!r}; a number above 0 is expected")
    return float(value)


def _at_least_zero(name: str, value: float) -> float:
    if not _is_number(value) or not value >= 0:
        raise InputError(name, f"{value!r}; a number of at least 0 is expected")
    return float(value)


def as_count(name: str, value: int) -> int:
    """A whole number from 0 on that the kernels can count with, or an ``InputError`` that names it."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < 2**31:
        raise InputError(name, f"{value!r}; a whole number from 0 to {2**31 - 1} is expected")
    return int(value)
