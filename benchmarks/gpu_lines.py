"""Stores a line for each figure of a GPU: speeds of calls and kernels, shares of goals, differences from the CPU."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import ulna
from benchmarks.gpu_timing import measured, memory_peak, resources

SAMPLE = 2000  # results that the CPU computes again
MANY = 1 << 20  # problems of the calls that have to be as fast as their kernel
SMALL = 1000, 100
Check = Callable[[Any], dict[str, float]]
"""Compares results with the CPU's; returns ``off``, the largest difference, and further figures."""

# Required problems per second of a kernel, on an H200. A call of ``MANY`` problems has to reach ``OF_CALL`` of it.
GOALS = {
    "poses": 6e9, "Jacobians": 3.5e9, "in_collision, 1 box": 1.2e9, "in_collision, cloud of 10^5 points": 2e7,
    "signed_distance, 20 boxes and a ball": 3e7, "inverse_kinematics, 1e-5": 3e7, "inverse_kinematics, 1e-5, clear of 1 box": 1e7,
    "all_solutions, UR5": 1.2e9, "edge_in_collision, 1 box": 5e6, "edge_in_collision, 20 boxes": 5e6,
}  # fmt: skip
OF_CALL = 0.8


class OutOfTime(Exception):  # noqa: N818 - no error: the rest is left out
    """The budget of time is spent."""


class Bench:
    """Measures calls, and stores a line for each figure.

    Attributes:
        n: The number of problems of a large batch.
        repeats: The number of calls of which the median counts.
        end: The time after which no figure is begun, of ``time.monotonic``.
        lines: The figures.
    """

    def __init__(self, n: int, repeats: int, end: float = float("inf")) -> None:
        self.n, self.repeats, self.end = n, repeats, end
        self.lines: list[dict[str, Any]] = []
        self._peak, self._kernels = memory_peak(), {}

    def rate(
        self, name: str, n: int, work: Callable[[], Any], check: Check | None = None, *,
        each_bytes: int = 0, like: str = "", calls: int = 1,
    ) -> Any:  # fmt: skip
        """Store a line: problems per second, shares, and the difference from the CPU. Returns the result.

        Args:
            name: What is measured.
            n: The number of problems of a call.
            work: The call.
            check: Compares the result with the CPU's; None for the CPU itself.
            each_bytes: The minimum that a problem reads and writes, where memory may bound the kernel; otherwise 0.
            like: The line whose kernel and goal this call is compared with, by default its own.
            calls: The number of calls of n problems that ``work`` makes.
        """
        self.refuse_late(name)
        found, took, launches = measured(work, self.repeats)
        took, launches = took / calls, {key: each._replace(seconds=each.seconds / calls) for key, each in launches.items()}
        line: dict[str, Any] = {"what": name, "n": n, **(check(found) if check else {})}
        line["per_second"] = n / took
        if n <= max(SMALL):
            line["microseconds"] = 1e6 * took
        self._add_kernels(line, launches, each_bytes)
        self._add_shares(line, like or name)
        self.lines.append(line)
        print(" ".join(f"{key} {_short(value)}" for key, value in line.items()), flush=True)
        return found

    def refuse_late(self, name: str) -> None:
        """Raise ``OutOfTime`` with the name of what comes next if the budget of time is spent."""
        if time.monotonic() > self.end:
            raise OutOfTime(name)

    def _add_kernels(self, line: dict[str, Any], launches: dict[str, Any], each_bytes: int) -> None:
        """Add the speed of all kernels of a call, the share of the memory's speed, and the resources of the longest kernel."""
        if not launches:
            return
        rate = line["n"] / sum(each.seconds for each in launches.values())
        line["kernel_per_second"] = rate
        self._kernels.setdefault(line["what"], rate)
        if each_bytes:
            line["bytes_per_second"] = rate * each_bytes
            if self._peak:
                line["of_memory"] = rate * each_bytes / self._peak
        if len(launches) > 1:
            line["kernels"] = {name: each.seconds for name, each in launches.items()}
        line.update(resources(max(launches.values(), key=lambda each: each.seconds)))

    def _add_shares(self, line: dict[str, Any], like: str) -> None:
        """Add the shares of the goal that kernel and call reach, and the call's share of the kernel's speed."""
        goal, kernel = GOALS.get(like), self._kernels.get(like)
        if kernel:
            line["call_of_kernel"] = line["per_second"] / kernel
        if goal and "kernel_per_second" in line and line["what"] == like:
            line["kernel_of_goal"] = line["kernel_per_second"] / goal
        if goal and line["n"] >= MANY:
            line["call_of_goal"] = line["per_second"] / goal
            line["call_reaches_goal"] = line["per_second"] >= OF_CALL * goal


def _short(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} {seconds:.4g}" for name, seconds in value.items())
    return f"{value:.4g}" if isinstance(value, float) else str(value)


# ---- worlds, and comparisons with the CPU --------------------------------------------------------------------------


def boxes(n: int) -> ulna.World:
    """A world of n boxes within the Panda's reach."""
    rng, world = np.random.default_rng(n), ulna.World()
    for k in range(n):
        world.add(
            f"box {k}", ulna.Box(tuple(rng.uniform(0.02, 0.15, 3))), ulna.pose(rng.uniform(-0.8, 0.8, 3), rng.uniform(-3, 3, 3))
        )
    return world


def host(array: Any) -> Any:
    """The first results, on the host."""
    array = array[:SAMPLE]
    return array.copy_to_host() if hasattr(array, "copy_to_host") else array


def off(expected: Any) -> Check:
    """The largest difference from the CPU's results, of numbers."""
    return lambda found: {"off": float(np.abs(host(found) * 1.0 - expected[:SAMPLE]).max())}


def differing(robot: ulna.Robot, q: Any, world: ulna.World, hair: float = 1e-9) -> Check:
    """The number of verdicts that differ from the CPU's, except within a tolerance of contact."""
    far, expected = np.abs(robot.signed_distance(q, world)) > hair, robot.in_collision(q, world)
    return lambda found: {"off": float(np.count_nonzero((host(found) != expected) & far))}


def differing_edges(expected: Any) -> Check:
    """The share of edges whose verdict differs from the CPU's; ``off`` is 1 above a thousandth: they may graze an object."""

    def check(found: Any) -> dict[str, float]:
        share = float(np.mean(host(found.in_collision) != expected.in_collision[:SAMPLE]))
        return {"off": float(share > 1e-3), "other_verdicts": share}

    return check


def same_branches(expected: Any) -> Check:
    """The largest difference of branches from the CPU's; infinite if other branches are real."""

    def check(found: Any) -> dict[str, float]:
        q, real = host(found.q), host(found.real)
        same = (real == expected.real[:SAMPLE]).all()
        return {"off": float(np.nanmax(np.abs(q - expected.q[:SAMPLE]))) if same else float("inf")}

    return check


def reaching(robot: ulna.Robot, T: Any, **options: Any) -> Check:
    """The largest error of the solutions by the CPU's poses, infinite if one is in collision; shares of solved targets."""

    def check(found: Any) -> dict[str, float]:
        some, success = host(T), np.asarray(found.success)
        solved, q, world = success[:SAMPLE], host(found.q), options.get("world")
        error = np.abs(robot.forward_kinematics(q) - some)[solved].max(initial=0.0)
        touches = world is not None and (robot.signed_distance(q[solved], world) < -1e-9).any()
        by_cpu = robot.inverse_kinematics(some, **options).success if not success.all() else solved
        shares = {"solved": float(success.mean()), "sample_solved": float(solved.mean()), "by_cpu": float(np.mean(by_cpu))}
        return {"off": float("inf") if touches else float(error), **shares}

    return check
