"""Measures calls on a GPU rather than kernels: chains of calls that do not wait, and small batches beside the CPU."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import ulna
from benchmarks.gpu_lines import SAMPLE, SMALL, Bench, Check, boxes, differing, differing_edges, off, reaching, same_branches
from ulna.gpu.device import cuda

_CHAIN = 20  # calls in a block


class Work(NamedTuple):
    """One method.

    Attributes:
        name: As in the lines of large batches.
        on_gpu: The call.
        on_cpu: The same call of the robot on the CPU.
        check: Makes the comparison from the CPU's result.
    """

    name: str
    on_gpu: Callable[[], Any]
    on_cpu: Callable[[], Any]
    check: Callable[[Any], Check]


def calls(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Calls of many problems into existing arrays: in a chain, and one by one."""
    on_gpu = robot.on_gpu()
    for work in _with_results(on_gpu, robot, q):
        check = work.check(work.on_cpu())
        _chain(bench, on_gpu, work, len(q), check)
        bench.rate(f"{work.name}, single calls, n {len(q)}", len(q), work.on_gpu, check, like=work.name)


def small_batches(bench: Bench, panda: ulna.Robot, ur5: ulna.Robot, q: Any) -> None:
    """Batches of ``SMALL`` sizes, of calls in a chain where no call waits, and of single calls, beside the CPU on all cores."""
    on_gpu = panda.on_gpu()
    for n in sorted({min(n, len(q)) for n in SMALL}, reverse=True):
        part = q[:n]
        deferring = _with_results(on_gpu, panda, part)
        waiting = [*_searches(on_gpu, panda, part), *_checks(on_gpu, panda, part), _branches(ur5, n)]
        for work in (*deferring, *waiting):
            check = work.check(work.on_cpu())
            if work in deferring:
                _chain(bench, on_gpu, work, n, check)
            bench.rate(f"{work.name}, single calls, n {n}", n, work.on_gpu, check, like=work.name)
            bench.rate(f"{work.name}, the CPU, n {n}", n, work.on_cpu)


def _chain(bench: Bench, on_gpu: Any, work: Work, n: int, check: Check) -> None:
    """Measure calls in one block of ``checked()``; ``microseconds`` is the time of one of them."""
    repeats = _CHAIN if bench.repeats > 1 else 1

    def several() -> Any:
        found = None
        with on_gpu.checked():
            for _ in range(repeats):
                found = work.on_gpu()
        return found

    bench.rate(f"{work.name}, calls in a chain, n {n}", n, several, check, like=work.name, calls=repeats)


def _with_results(on_gpu: Any, robot: ulna.Robot, q: Any) -> list[Work]:
    """Methods that write into existing arrays."""
    there, n, few, one = cuda.to_device(q), len(q), boxes(20), boxes(1)
    poses, jacobians, hits = (
        cuda.device_array((n, *shape), kind) for shape, kind in (((4, 4), float), ((6, 7), float), ((), bool))
    )
    some = q[:SAMPLE]

    def touching(name: str, world: ulna.World) -> Work:
        return Work(
            f"in_collision, {name}", lambda: on_gpu.in_collision(there, world, out=hits), lambda: robot.in_collision(q, world),
            lambda _: differing(robot, some, world),
        )  # fmt: skip

    return [
        Work("poses", lambda: on_gpu.forward_kinematics(there, out=poses), lambda: robot.forward_kinematics(q), off),
        Work("Jacobians", lambda: on_gpu.jacobian(there, out=jacobians), lambda: robot.jacobian(q), off),
        touching("1 box", one), touching("20 boxes", few),
    ]  # fmt: skip


def _searches(on_gpu: Any, robot: ulna.Robot, q: Any) -> list[Work]:
    """Inverse kinematics, without a world and clear of a box."""
    T, world = robot.forward_kinematics(q), boxes(1)
    targets = cuda.to_device(T)
    ways: dict[str, dict[str, Any]] = {"": {}, ", clear of 1 box": {"world": world}}
    return [
        Work(
            f"inverse_kinematics, 1e-5{name}", lambda o=options: on_gpu.inverse_kinematics(targets, **o),
            lambda o=options: robot.inverse_kinematics(T, **o), lambda _, o=options: reaching(robot, T, **o),
        )
        for name, options in ways.items()
    ]  # fmt: skip


def _checks(on_gpu: Any, robot: ulna.Robot, q: Any) -> list[Work]:
    """Distances, edges and torques."""
    rng, world = np.random.default_rng(6), boxes(20)
    ends, rates = q + rng.normal(scale=0.2, size=q.shape), rng.normal(size=(2, *q.shape))
    there, end, *motion = map(cuda.to_device, (q, ends, *rates))

    def expected() -> Any:
        return robot.signed_distance(q, world)

    return [
        Work("signed_distance, 20 boxes", lambda: on_gpu.signed_distance(there, world), expected, off),
        Work(
            "edge_in_collision, 20 boxes", lambda: on_gpu.edge_in_collision(there, end, world),
            lambda: robot.edge_in_collision(q, ends, world), differing_edges,
        ),
        Work(
            "inverse_dynamics", lambda: on_gpu.inverse_dynamics(there, *motion), lambda: robot.inverse_dynamics(q, *rates), off
        ),
    ]  # fmt: skip


def _branches(ur5: ulna.Robot, n: int) -> Work:
    """All solutions of a UR5."""
    on_gpu, T = ur5.on_gpu(), ur5.forward_kinematics(ur5.random(n, seed=3))
    targets = cuda.to_device(T)
    return Work("all_solutions, UR5", lambda: on_gpu.all_solutions(targets), lambda: ur5.all_solutions(T), same_branches)
