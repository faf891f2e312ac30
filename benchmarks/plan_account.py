"""Where the time of a plan goes, on VAMP's problems: ``python -m benchmarks.plan_account RESOURCES/panda --every 7``.

Each part is called by itself, several times; the least time counts, and the table has the medians over the problems. "Python"
is the whole call less what the compiled search, shortening and confirmation took. A verdict is one configuration of a sampled
edge that is free; it is also looked at with ``in_collision`` of a batch.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

import ulna
import ulna.planning.motion as planning_motion
import ulna.planning.search as planning_search
from benchmarks.plans import leave_out_touched
from benchmarks.vamp_problems import PlanningProblem, read_problems, spheres
from ulna.engine.lanes import WIDTH
from ulna.planning.motion import SAMPLES_APART, EdgeChecker
from ulna.planning.search import Search
from ulna.planning.slices import TimeLimit

REPEATS = 5
CONFIGURATIONS = 4096


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.plan_account", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=7, help="one problem of so many")
    parser.add_argument("--boxes", action="store_true", help="Ulna's Panda of twelve boxes, among exact cylinders")
    options = parser.parse_args()
    robot = ulna.load("panda") if options.boxes else spheres(options.folder)
    rows: dict[str, list[dict[str, float]]] = {"certified": [], "sampled": []}
    for problem in read_problems(options.folder, robot.joint_names)[:: options.every]:
        world = problem.world(exact=options.boxes)
        if options.boxes:
            leave_out_touched(robot, world, problem)
        if robot.in_collision([problem.start, problem.goal], world).any():
            continue
        for how, some in rows.items():
            some.append(account(robot, problem, world, certify=how == "certified"))
    print(f"{'median over the problems':46}" + "".join(f"{how:>12}" for how in rows))
    for part in rows["certified"][0]:
        print(f"{part:46}" + "".join(f"{np.median([row[part] for row in some]):12.4g}" for some in rows.values()))


def account(robot: ulna.Robot, problem: PlanningProblem, world: ulna.World, *, certify: bool) -> dict[str, float]:
    """The parts of one plan [us]."""
    inside = _Entry()
    whole, plan = _least(lambda: robot.plan(problem.start, problem.goal, world, certify=certify), inside)
    compiled = inside.seconds
    motion = plan._searched.motion  # noqa: SLF001 - what the plan was found with
    edges = motion.edges(certify=certify)
    search, found = _least(lambda: _search(edges, problem), inside)
    shorten, _ = _least(lambda: edges.checked(found.path, shorten=True), inside)
    kernel_of_shortening = inside.seconds
    _least(lambda: edges.checked(plan.path), inside)
    kernel_of_confirming, n_edges = inside.seconds, len(plan.path) - 1
    _least(lambda: edges.checked(plan.path[:1]), inside)
    setup = inside.seconds
    lengths = np.linalg.norm(np.diff(plan.path, axis=0), axis=1)
    samples = WIDTH * np.ceil(lengths / (SAMPLES_APART * WIDTH)).sum()
    q = plan.at(np.linspace(0.0, 1.0, CONFIGURATIONS))
    batch, _ = _least(lambda: robot.in_collision(q, world, threads=1), inside)
    fresh, _ = _least(lambda: problem.world(exact=False).objects(), inside)
    return {
        "whole [us]": 1e6 * whole,
        "compiled [us]": 1e6 * compiled,
        "Python [us]": 1e6 * (whole - compiled),
        "search and confirmation with their Python [us]": 1e6 * search,
        "shortening with its Python [us]": 1e6 * shorten,
        "shortening, compiled [us]": 1e6 * kernel_of_shortening,
        "confirmation, compiled [us]": 1e6 * kernel_of_confirming,
        "an entry call without edges [us]": 1e6 * setup,
        "calls of the entry": inside.calls_of_first,
        "checked edges": plan.checks,
        "edges of the path": n_edges,
        "a free edge of the path [us]": 1e6 * (kernel_of_confirming - setup) / n_edges,
        "radians a free edge": lengths.mean(),
        "ns a configuration of the path": np.nan if certify else 1e9 * (kernel_of_confirming - setup) / samples,
        "ns a configuration, in_collision": 1e9 * batch / CONFIGURATIONS,
        "objects": len(world.names),
        "a world laid out anew [us]": 1e6 * fresh,
    }


def _search(edges: EdgeChecker, problem: PlanningProblem):
    return Search(edges, problem.start, problem.goal[None], (0,)).finish(100_000, TimeLimit(None), shorten=False)


class _Entry:
    """Counts the calls of the compiled entry within a call of Python, and their time."""

    def __init__(self) -> None:
        self.seconds, self.calls, self.calls_of_first = 0.0, 0, 0
        self._real = planning_search.driver
        self._timed = SimpleNamespace(plan_slice=self._plan_slice)

    def __enter__(self) -> None:
        self.seconds, self.calls = 0.0, 0
        planning_search.driver = planning_motion.driver = self._timed

    def __exit__(self, *_: object) -> None:
        planning_search.driver = planning_motion.driver = self._real
        self.calls_of_first = self.calls_of_first or self.calls

    def _plan_slice(self, *arguments: Any) -> Any:
        began = time.thread_time()
        result = self._real.plan_slice(*arguments)
        self.seconds += time.thread_time() - began
        self.calls += 1
        return result


def _least(function: Callable, inside: _Entry) -> tuple[float, Any]:
    """The least time of a call [s], and what it returned; ``inside`` keeps the compiled part of that call."""
    least, compiled, result = np.inf, 0.0, None
    for _ in range(REPEATS):
        with inside:
            began = time.thread_time()
            result = function()
            seconds = time.thread_time() - began
        if seconds < least:
            least, compiled = seconds, inside.seconds
    inside.seconds = compiled
    return least, result


if __name__ == "__main__":
    main()
