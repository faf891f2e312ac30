"""Checks the targets and configurations of one call, and shapes them for the kernels."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.errors import InputError, UnknownNameError
from ulna.ik.bounds import narrowed
from ulna.ik.query import Query
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.positions import as_positions, refuse_out_of_range, rows_of
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Problem:
    """A query with the targets of one call.

    Attributes:
        query: What does not depend on the targets.
        chain: The chain to the task's frame.
        targets: Poses of the task's frame, shape (n, 4, 4).
        batch: The shape of the batch that they were given in.
        seeds: Shape (n or 1, n_dof), within the limits.
        seeded: Whether the caller gave them.
        bounds: Where q may be and where starts are taken from, shape (n or 1, 4, n_dof).
        is_narrowed: Whether the bounds are narrower than the limits.
        posture: Shape (n_dof,); read if the settings say so.
        settings: Those of the kernels, shape (N_SETTINGS,).
        nearest_to: Of solutions that differ by whole turns the nearest to these is taken, shape (n or 1, n_dof); None: any.
    """

    query: Query
    chain: Array
    targets: Array
    batch: tuple[int, ...]
    seeds: Array
    seeded: bool
    bounds: Array
    is_narrowed: bool
    posture: Array
    settings: Array
    nearest_to: Array | None


def make_problem(
    query: Query,
    T: ArrayLike,
    q_seed: ArrayLike | None,
    posture: ArrayLike | str | None = None,
    held: tuple[str, ...] = (),
) -> Problem:
    """A query with targets. The arguments are those of ``Robot.inverse_kinematics``.

    Raises:
        InputError: An argument that the search cannot take. Whether targets are rigid motions is checked by the kernels.
        UnknownNameError: There is no such joint.
    """
    tree, max_step = query.tree, query.options.max_step
    if max_step is not None and q_seed is None:
        raise InputError("max_step", "bounds the way from q_seed, so q_seed is needed too")
    targets, seeds = _targets_and_seeds(_targets(T), query.home.copy() if q_seed is None else _seeds(tree, q_seed))
    batch = targets.shape[:-2]
    if query.options.trace and batch:
        raise InputError("trace", "a trace is of one target, shape (4, 4)")
    settings = query.settings.copy()
    settings[layout.WITH_POSTURE] = posture is not None
    columns, step = _columns(tree, held), np.inf if max_step is None else max_step
    clipped = np.clip(seeds, tree.lower, tree.upper)
    return Problem(
        query=query,
        chain=query.chain,
        targets=of_task(query, targets.reshape(-1, 4, 4)),
        batch=batch,
        seeds=clipped,
        seeded=q_seed is not None,
        bounds=narrowed(query.limits, seeds, columns, step),
        is_narrowed=bool(columns) or np.isfinite(step),
        posture=query.home.copy() if posture is None else _posture(tree, posture),
        settings=settings,
        nearest_to=clipped if query.options.rank == "nearest" else None,
    )


def refuse_no_pose(T: ArrayLike) -> None:
    """Raise the ``InputError`` that says which target is no rigid motion; for targets that the kernels found to be none.

    Raises:
        InputError: Always.
    """
    as_pose(as_floats("T", T))
    raise InputError("T", "is further than 1e-6 from a rigid motion, so it is not a pose")  # by the last bit only


def _targets(T: ArrayLike) -> Array:
    targets = as_floats("T", T)
    if targets.shape[-2:] != (4, 4):
        raise InputError("T", f"shape {targets.shape}, but targets have shape (..., 4, 4); ulna.pose(xyz, rpy) makes one")
    return targets


def of_task(query: Query, targets: Array) -> Array:
    """Targets of the task's frame, from those of the link."""
    if query.task_axes is None:
        return targets
    return targets @ query.T_link_task


def as_names(held: Iterable[str]) -> tuple[str, ...]:
    """The names of joints that are held, one or several.

    Raises:
        InputError: ``held`` is not iterable.
    """
    try:
        return (held,) if isinstance(held, str) else tuple(held)
    except TypeError:
        raise InputError("held", f"{held!r}; names of joints are expected") from None


def _columns(tree: Tree, held: tuple[str, ...]) -> tuple[int, ...]:
    """The entries of q that belong to the joints that are held."""
    columns: list[int] = []
    for name in held:
        if name not in tree.joint_names:
            raise UnknownNameError("joint", str(name), tree.joint_names)
        columns += range(tree.n_dof)[tree.joint_slices[tree.joint_names.index(name)]]
    return tuple(columns)


def _seeds(tree: Tree, q_seed: ArrayLike) -> Array:
    seeds = as_positions(q_seed, tree, "q_seed")
    refuse_out_of_range(seeds, "q_seed")
    return seeds


def _targets_and_seeds(targets: Array, seeds: Array) -> tuple[Array, Array]:
    """Targets (..., 4, 4) and their seeds (n or 1, n_dof): one seed for all targets, one for each, or several for one target."""
    if seeds.ndim == 1:
        return targets, seeds.reshape(1, -1)
    try:
        batch = np.broadcast_shapes(targets.shape[:-2], seeds.shape[:-1])
    except ValueError:
        message = f"shape {seeds.shape} does not go with targets of batch shape {targets.shape[:-2]}"
        raise InputError("q_seed", f"{message}: give one seed, one for each target, or several for one target") from None
    if batch != targets.shape[:-2]:
        targets = np.array(np.broadcast_to(targets, (*batch, 4, 4)), order="C")
    return targets, rows_of(seeds, batch)


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
        raise InputError("posture", f"shape {goal.shape}, but one posture, shape ({tree.n_dof},), is expected for all targets")
    refuse_out_of_range(goal, "posture")
    return np.clip(goal, tree.lower, tree.upper)
