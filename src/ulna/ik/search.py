"""The search itself: the method by its name, the rounds below, the reasons behind what was not found, the result above."""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError, did_you_mean
from ulna.ik.all_solutions import all_solutions
from ulna.ik.collision_filter import Obstacles
from ulna.ik.explain import Reasons, close_unreachable, explain_open, reach_in_words, settle_open
from ulna.ik.problem import DEFAULT_BUDGET, Problem, as_count, make_problem, refuse_what_is_no_pose
from ulna.ik.ranking import cost_of
from ulna.ik.restarts import Cost, Search, search_with_restarts
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.single_target import LEAST_BUDGET, SingleTarget, SingleTargetKey
from ulna.ik.task import Task, as_task
from ulna.ik.textbook import TEXTBOOK, follow
from ulna.ik.trace import convergence
from ulna.kernels.ik import search_layout as layout
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
METHODS = ("levenberg_marquardt", *TEXTBOOK)
TEXTBOOK_BUDGET = 10_000
_FEW, _MANY = 2, 16  # random starts in the first round: where any solution will do, and where the best is to be chosen


def inverse_kinematics(
    tree: Tree,
    T: ArrayLike,
    link: str,
    home: Array,
    *,
    q_seed: ArrayLike | None,
    method: str,
    seed: int,
    task: Task | str,
    rank: str | None,
    posture: ArrayLike | str | None,
    held: Iterable[str],
    max_step: float | None,
    tolerances: tuple[float, float],
    max_iterations: int | None,
    time_limit: float | None,
    threads: int | None,
    trace: bool,
    obstacles: Obstacles | None,
    quick: Callable[[SingleTargetKey], SingleTarget],
) -> IKResult:
    """Configurations at which ``link`` stands at T; see ``Robot.inverse_kinematics``."""
    if method not in METHODS:
        raise InputError("method", f"{method!r} is not a method{did_you_mean(str(method), METHODS)}")
    budget = DEFAULT_BUDGET if method == "levenberg_marquardt" else TEXTBOOK_BUDGET
    problem = make_problem(
        tree, T, link, home, q_seed=q_seed, task=as_task(task), posture=posture, held=held, max_step=max_step,
        tolerances=tolerances, seed=seed, budget=budget if max_iterations is None else max_iterations, time_limit=time_limit,
        threads=threads,
    )  # fmt: skip
    if trace and problem.batch:
        raise InputError("trace", "a trace is of one target, shape (4, 4)")
    if method in TEXTBOOK:
        for name, given in (("posture", posture), ("rank", rank), ("world", obstacles), ("time_limit", time_limit)):
            if given is not None:
                raise InputError(name, f"the method {method!r} takes none: it goes from the seed alone, wherever that leads")
        return _as_result(problem, *follow(problem, method, trace=trace), T)
    return _levenberg_marquardt(problem, T, q_seed, rank, obstacles, quick, trace=trace)


def _levenberg_marquardt(
    problem: Problem,
    T: ArrayLike,
    q_seed: ArrayLike | None,
    rank: str | None,
    obstacles: Obstacles | None,
    quick: Callable[[SingleTargetKey], SingleTarget],
    *,
    trace: bool,
) -> IKResult:
    price = cost_of(problem, rank, obstacles)
    if rank == "nearest":
        problem = replace(problem, nearest_to=problem.seeds)
    if _is_plain(problem, rank, obstacles):
        result = quick((problem.link, *problem.tolerances, problem.seed)).solve(T, q_seed)
        if result is not None:
            notes = {"trace": convergence(problem, result.info[0])} if trace else {}
            return _as_result(problem, result.q[None], result.info, notes, T)
    search, reasons = _search(problem, price, many=_FEW if rank is None and obstacles is None else _MANY, seed_alone=rank is None)
    notes = {"reach_excess": reasons.reach_excess, "limit_excess": reasons.limit_excess, "turn": problem.task.turn}
    if not problem.batch and reasons.reach_excess:
        notes["bound"] = reach_in_words(problem, 0)
    if reasons.limit_excess:
        notes["entries"] = entry_names(problem.tree)
    if obstacles is not None:
        hit = np.flatnonzero(search.info[:, layout.STATUS] == CODES[Status.IN_COLLISION])
        notes["collisions"] = {int(i): obstacles.pairs(search.q[i]) for i in hit}
    if trace:
        notes["trace"] = convergence(problem, search.info[0], search.origins.get(0))
    return _as_result(problem, search.q, search.info, notes, T)


def inverse_kinematics_all(
    tree: Tree,
    T: ArrayLike,
    link: str,
    home: Array,
    *,
    q_seed: ArrayLike | None,
    seed: int,
    task: Task | str,
    tolerances: tuple[float, float],
    n_spread: int,
) -> Array:
    """Distinct solutions, shape (n, n_dof); see ``Robot.inverse_kinematics_all``."""
    problem = make_problem(
        tree, T, link, home, q_seed=q_seed, task=as_task(task), posture=None, held=(), max_step=None, tolerances=tolerances,
        seed=seed, budget=DEFAULT_BUDGET, time_limit=None, threads=1,
    )  # fmt: skip
    if problem.batch or len(problem.seeds) != 1:
        raise InputError("T", f"shape {np.shape(T)}: all solutions are found for one target and one seed at a time")
    refuse_what_is_no_pose(T)
    return all_solutions(problem, as_count("n_spread", n_spread))


def _is_plain(problem: Problem, rank: str | None, obstacles: Obstacles | None) -> bool:
    """Whether this is one target without special wishes, which takes the short way whatever form the arguments have."""
    asked = problem.batch or problem.task.kind != layout.WHOLE_POSE or problem.settings[layout.WITH_POSTURE]
    narrowed = problem.is_narrowed or problem.budget < LEAST_BUDGET
    return not (asked or narrowed or rank is not None or obstacles is not None or problem.time_limit == 0.0)


def _search(problem: Problem, price: Cost | None, many: int, *, seed_alone: bool) -> tuple[Search, Reasons]:
    reasons = Reasons()
    search, out_of_time = search_with_restarts(
        problem, price, many, lambda search: close_unreachable(search, reasons), seed_alone=seed_alone
    )
    if not (search.info[:, layout.STATUS] == layout.SOLVED).all():
        settle_open(search, price, out_of_time=out_of_time)
        explain_open(search, reasons, price, out_of_time=out_of_time)
    return search, reasons


def _as_result(problem: Problem, q: Array, info: Array, notes: dict, T: ArrayLike) -> IKResult:
    if (info[:, layout.STATUS] == layout.NOT_A_POSE).any():
        refuse_what_is_no_pose(T)
        raise InputError("T", "is further than 1e-6 from a rigid motion, so it is not a pose")  # by the last bit only
    q = q.reshape(*problem.batch, q.shape[-1])
    return IKResult(q, info, problem.batch, problem.tolerances, notes)


def entry_names(tree: Tree) -> list[str]:
    """A name for every entry of q: the joint's, with a number behind it where a joint has several."""
    parts = [(name, range(tree.n_dof)[cut]) for name, cut in zip(tree.joint_names, tree.joint_slices, strict=True)]
    return [f"{name}[{k}]" if len(cut) > 1 else name for name, cut in parts for k in range(len(cut))]
