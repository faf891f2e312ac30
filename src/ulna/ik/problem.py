"""Prepares a search: once for a link and options (``Query``), then for the targets of one call (``Problem``).

``Options`` are the caller's choices. ``Task`` is one of them: the components of a pose to reach.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.engine.records import Records, replaced
from ulna.errors import InputError
from ulna.ik.options import Options
from ulna.kernels.ik.search_records import SearchSettings
from ulna.kernels.layout import COLUMN, KIND, LARGEST, PRISMATIC, RATIO
from ulna.kinematics.positions import as_positions, columns_of_joints, refuse_out_of_range, rows_of
from ulna.kinematics.reach import Reach, reach_of
from ulna.kinematics.sample import usual_range
from ulna.kinematics.size import length_of, units_of
from ulna.kinematics.tree import Tree, lengthened

Array = NDArray[np.float64]
STEPS, SEEDED_STEPS = 20, 60  # steps from one start before the next; from the caller's own
_TIMES = 2.0  # factor: no two points of an arm are farther apart than this times its length
_MIN_STEP = 1e-6  # m
_USUAL = 32.0  # m, and 1 / 32 m: an arm of a size between them is measured in meters


@dataclass(frozen=True, eq=False)
class Query:
    """One link of a robot, and the options of a search: everything that does not depend on the target.

    Attributes:
        tree: The robot.
        home: The start of a search without a seed [rad or m], shape (n_dof,).
        checker: The robot's collision checker, used if a world is given.
        link: The link to bring to the target.
        options: The caller's options, validated.
    """

    tree: Tree
    home: Array
    checker: Checker
    link: str
    options: Options

    def __post_init__(self) -> None:
        object.__setattr__(self, "options", self.options.checked())
        refuse_immovable(self.tree)
        self.tree.chain(self.link)

    @cached_property
    def task_axes(self) -> Array | None:
        """The axes of the task in the link, shape (3, 3); None if they are the link's own."""
        return self.options.task.turn

    @cached_property
    def T_link_task(self) -> Array:  # noqa: N802 - a pose
        """The pose of the task's frame in the link, shape (4, 4)."""
        return self.options.task.frame

    @cached_property
    def chain(self) -> Array:
        """The chain to the task's frame: the link's frame, rotated by ``task_axes``."""
        chain = self.tree.chain(self.link)
        if self.task_axes is None:
            return chain
        return lengthened(chain, self.T_link_task)

    @cached_property
    def limits(self) -> Array:
        """Lower and upper limits, and the usual range for random starts: shape (1, 4, n_dof)."""
        return np.array([[*self.tree.bounds, *usual_range(*self.tree.bounds)]])

    @cached_property
    def settings(self) -> Records[SearchSettings]:
        """The settings of the kernels, one record."""
        records, options = SearchSettings.records(), self.options
        settings = records[0]
        settings.position_tolerance, settings.rotation_tolerance = options.tolerances
        settings.steps, settings.task, settings.max_square = STEPS, options.task.kind, self._far_square
        settings.slack[:] = options.task.slack
        return records

    @property
    def _far_square(self) -> float:
        """The square of the distance [m^2] that only prismatic joints can bridge; 0 if no stroke is as long."""
        tree, max_reach = self.tree, max(_TIMES * arm_length(self.tree, self.link), _MIN_STEP)
        slides = [row for row in tree.chain(self.link) if int(row[KIND]) == PRISMATIC]
        lower, upper = np.clip(tree.lower, -LARGEST, LARGEST), np.clip(tree.upper, -LARGEST, LARGEST)
        strokes = [abs(row[RATIO]) * (upper[int(row[COLUMN])] - lower[int(row[COLUMN])]) for row in slides]
        return max_reach * max_reach if any(way > max_reach for way in strokes) else 0.0

    @cached_property
    def unit(self) -> float:
        """The unit of length of the search [m]: 1 for arms of the usual size."""
        length = arm_length(self.tree, self.link)  # a power of two, so that conversions to and from it are exact
        return 1.0 if length == 0.0 or 1 / _USUAL <= length <= _USUAL else float(2.0 ** np.rint(np.log2(length)))

    @cached_property
    def units(self) -> Array:
        """The unit of each entry of q, shape (n_dof,): 1 for an angle, else the size of the arm [m]."""
        return units_of(self.tree.chain(self.link), self.tree.lower, self.tree.upper)

    @cached_property
    def reach(self) -> Reach | None:
        """The reach of the link; None if it is unbounded."""
        return reach_of(self.tree.chain(self.link), self.tree.lower, self.tree.upper)


def refuse_immovable(tree: Tree) -> None:
    """Raise an error for a robot without joints."""
    if not tree.n_dof:
        raise InputError("T", "the robot has no moving joints, so nothing can be solved for")


def arm_length(tree: Tree, link: str) -> float:
    """The sum of the lengths of all parts of the chain to a link [m], with prismatic joints at 0."""
    return length_of(tree.chain(link))


def narrowed(limits: Array, seeds: Array, held: NDArray[np.bool_], max_step: float) -> Array:
    """The limits, narrowed by held joints and the maximum step: shape (1 or n_seeds, 4, n_dof).

    Args:
        limits: Lower and upper limits and the usual range, shape (1, 4, n_dof).
        seeds: [rad or m], shape (n_seeds, n_dof).
        held: Mask of the entries of q that stay at the seed, shape (n_dof,).
        max_step: The maximum difference of an entry from the seed [rad or m].
    """
    if not held.any() and np.isinf(max_step):
        return limits
    reach = np.full(limits.shape[-1], max_step)
    reach[held] = 0.0
    lower, upper = np.maximum(limits[:, 0], seeds - reach), np.minimum(limits[:, 1], seeds + reach)
    beyond = np.argwhere(lower > upper)
    if len(beyond):
        what = "a joint that is held" if reach[beyond[0][1]] == 0.0 else "a joint"
        raise InputError("q_seed", f"{what} is further beyond its limits than it may move (entry {beyond[0][1]} of q)")
    low, high = np.clip(limits[:, 2], lower, upper), np.clip(limits[:, 3], lower, upper)
    return np.stack([lower, upper, low, high], axis=1)


@dataclass(frozen=True, eq=False)
class Problem:
    """A query with the targets of one call.

    Attributes:
        query: The link and the options.
        chain: The chain to the task's frame.
        targets: Poses of the task's frame, shape (n, 4, 4).
        batch: The batch shape of the given targets.
        seeds: Shape (n or 1, n_dof), within the limits.
        seeded: Whether the caller gave them.
        bounds: Bounds of q, and the range of random starts, shape (n or 1, 4, n_dof).
        is_narrowed: Whether the bounds are narrower than the limits.
        posture: Shape (n_dof,); read if the settings enable it.
        settings: The settings of the kernels, one record.
        nearest_to: Among solutions that differ by whole turns, the one nearest to these is chosen, shape (n or 1, n_dof); None:
            any.
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
    settings: Records[SearchSettings]
    nearest_to: Array | None

    def subset(self, order: NDArray[np.int64]) -> "Problem":
        """The problem of some of the targets, by index (m,); indices may repeat."""
        seeds, bounds = (rows[order] if len(rows) > 1 else rows for rows in (self.seeds, self.bounds))
        goal = None if self.nearest_to is None else rows_for(self.nearest_to, order)
        return replace(self, targets=self.targets[order], seeds=seeds, bounds=bounds, nearest_to=goal, batch=(len(order),))


def excess_of(q: Array, lower: Array, upper: Array) -> Array:
    """The excess of entries of q (..., n_dof) over their limits [rad or m]; 0 within them."""
    return np.maximum(np.maximum(lower - q, q - upper), 0.0)


def make_problem(
    query: Query,
    T: ArrayLike,
    q_seed: ArrayLike | None,
    posture: ArrayLike | str | None = None,
    held: tuple[str, ...] = (),
) -> Problem:
    """A query with targets. The arguments are those of ``Robot.inverse_kinematics``."""
    tree, max_step = query.tree, query.options.max_step
    if max_step is not None and q_seed is None:
        raise InputError("max_step", "bounds the motion from q_seed, so q_seed is needed too")
    targets, seeds = _targets_and_seeds(_targets(T), query.home.copy() if q_seed is None else _seeds(tree, q_seed))
    batch = targets.shape[:-2]
    if query.options.trace and batch:
        raise InputError("trace", "a trace is of one target, shape (4, 4)")
    columns, step = columns_of_joints(tree, held), np.inf if max_step is None else max_step
    clipped = np.clip(seeds, tree.lower, tree.upper)
    return Problem(
        query=query,
        chain=query.chain,
        targets=of_task(query, targets.reshape(-1, 4, 4)),
        batch=batch,
        seeds=clipped,
        seeded=q_seed is not None,
        bounds=narrowed(query.limits, seeds, columns, step),
        is_narrowed=bool(columns.any() or np.isfinite(step)),
        posture=query.home.copy() if posture is None else _posture(tree, posture),
        settings=query.settings if posture is None else replaced(query.settings, with_posture=True),
        nearest_to=clipped if query.options.rank == "nearest" else None,
    )


def rows_for(rows: Array, order: NDArray[np.int64]) -> Array:
    """The rows of some targets (m,); a single row serves all."""
    return rows[np.minimum(order, len(rows) - 1)]


def refuse_no_pose(T: ArrayLike) -> None:
    """Raise the ``InputError`` for the target that is no rigid motion, after the kernels found one."""
    as_pose(as_floats("T", T))
    raise InputError("T", "is further than 1e-6 from a rigid motion, so it is not a pose")  # by the last bit only


def _targets(T: ArrayLike) -> Array:
    targets = as_floats("T", T)
    if targets.shape[-2:] != (4, 4):
        raise InputError("T", f"shape {targets.shape}, but targets have shape (..., 4, 4); ulna.pose(xyz, rpy) makes one")
    return targets


def of_task(query: Query, targets: Array) -> Array:
    """Convert targets of the link to targets of the task's frame."""
    if query.task_axes is None:
        return targets
    return targets @ query.T_link_task


def _seeds(tree: Tree, q_seed: ArrayLike) -> Array:
    seeds = as_positions(q_seed, tree, "q_seed")
    refuse_out_of_range(seeds, "q_seed")
    return seeds


def _targets_and_seeds(targets: Array, seeds: Array) -> tuple[Array, Array]:
    """Broadcast targets (..., 4, 4) and seeds (n or 1, n_dof): one seed, one each, or several for one target."""
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
    """The middle of every joint's range; without a range 0, or the limit nearest to it."""
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
