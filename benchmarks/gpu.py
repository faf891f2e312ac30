"""Measures problems per second on a GPU, and compares each result with the CPU: ``make bench-gpu``, a few minutes.

Every figure is the median of repeated calls between two synchronizations, without compilation. ``bytes`` is the minimum that a
problem reads and writes, for the share of the memory's speed. Registers and local memory are the compiler's figures; threads at
once are those that a multiprocessor can hold. The memory bounds a method if its share is near 1. Otherwise the units for float64
(or float32) bound it, or the latency of too few threads.

ARGS="--n 65536 --repeats 3" measures less. ``--out FILE`` writes the lines as JSON.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import ulna
from ulna.gpu import device
from ulna.gpu.collision import overlaps_of
from ulna.gpu.device import cuda
from ulna.gpu.forward import jacobians_of, poses_of
from ulna.gpu.scenes import BOXES
from ulna.gpu.search import searches_of
from ulna.gpu.single import in_single
from ulna.gpu.solutions import branches_of
from ulna.gpu.torques import derivatives_of, forward_of, gravity_of, inverse_of, masses_of

_SAMPLE = 2000  # results that the CPU computes again
# Required problems per second, on an H200.
GOALS = {
    "poses": 1e9, "Jacobians": 5e8, "in_collision, 1 box": 2e8, "in_collision, 20 boxes": 5e7, "in_collision, 100 boxes": 1e7,
    "in_collision, cloud of 10^5 points": 2e7, "inverse_kinematics, 1e-5": 1e7, "inverse_dynamics": 2e9,
    "all_solutions, UR5": 5e8,
}  # fmt: skip
UR5 = [
    (0, 0.089159, np.pi / 2, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0),
    (0, 0.10915, np.pi / 2, 0), (0, 0.09465, -np.pi / 2, 0), (0, 0.0823, 0, 0),
]  # fmt: skip


class Bench:
    """Measures one robot, and stores a line for each figure."""

    def __init__(self, n: int, repeats: int) -> None:
        self.n, self.repeats, self.lines = n, repeats, []
        self.peak = _memory_peak()

    def seconds(self, work: Callable[[], Any]) -> float:
        """The median time of a call, including everything it launches."""
        work()
        cuda.synchronize()
        times = []
        for _ in range(self.repeats):
            start = time.perf_counter()
            work()
            cuda.synchronize()
            times.append(time.perf_counter() - start)
        return float(np.median(times))

    def kernel_seconds(self, work: Callable[[], Any]) -> float:
        """The median time of a call's launches on the device, by events."""
        times, run = [], device.run

        def timed(*given: Any, **named: Any) -> None:
            begin, end = cuda.event(), cuda.event()
            begin.record()
            run(*given, **named)
            end.record()
            end.synchronize()
            times.append(1e-3 * cuda.event_elapsed_time(begin, end))

        device.run = timed
        try:
            for _ in range(self.repeats):
                work()
        finally:
            device.run = run
        return float(np.median(times)) if times else float("nan")

    def rate(
        self, name: str, n: int, each_bytes: int, work: Callable[[], Any], check: Callable[[Any], float], driver: Any = None
    ):
        """A line: problems per second, the shares of the goal and of the memory's speed, the difference from the CPU."""
        worst, took = check(work()), self.seconds(work)
        line = {"what": name, "n": n, "per_second": n / took, "bytes_per_second": n * each_bytes / took, "off": worst}
        if name in GOALS:
            line["of_goal"] = n / took / GOALS[name]
        if self.peak:
            line["of_memory"] = n * each_bytes / took / self.peak
        line.update(_resources(driver))
        if driver is not None and not cuda.config.ENABLE_CUDASIM:
            line["kernel_per_second"] = n / self.kernel_seconds(work)
        self.lines.append(line)
        print(
            " ".join(f"{key} {value:.4g}" if isinstance(value, float) else str(value) for key, value in line.items()), flush=True
        )


def _memory_peak() -> float | None:
    """Bytes per second of the device's memory, from its clock and bus width; None if unknown."""
    device = cuda.get_current_device()
    clock, width = (getattr(device, name, 0) for name in ("MEMORY_CLOCK_RATE", "GLOBAL_MEMORY_BUS_WIDTH"))
    return 2.0 * clock * 1000.0 * width / 8.0 or None


def _resources(driver: Any) -> dict[str, int]:
    """Registers, local memory and concurrent threads of a driver that has run."""
    if driver is None or cuda.config.ENABLE_CUDASIM:
        return {}
    kernel = device.compiled(driver)
    registers = max(kernel.get_regs_per_thread().values())
    rounded = -(-registers // 8) * 8
    return {
        "registers": registers, "local_bytes": max(kernel.get_local_mem_per_thread().values()),
        "threads_at_once": min(2048, 65536 // (rounded * device.THREADS) * device.THREADS),
    }  # fmt: skip


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
    return array[:_SAMPLE].copy_to_host()


def off(expected: Any) -> Callable[[Any], float]:
    """The largest difference from the CPU's results."""
    return lambda found: float(np.abs(host(found) - expected).max())


def differs(robot: ulna.Robot, q: Any, world: ulna.World, hair: float) -> Callable[[Any], float]:
    """The number of verdicts that differ from the CPU's, except within a tolerance of contact."""
    far = np.abs(robot.signed_distance(q, world)) > hair
    return lambda found: float(np.count_nonzero((host(found) != robot.in_collision(q, world)) & far))


def methods(bench: Bench, robot: ulna.Robot, q: Any, *, float32: bool) -> None:
    """Poses, Jacobians and collisions, in float64 or float32."""
    on_gpu, size = robot.on_gpu(float32=float32), 4 if float32 else 8
    q = q.astype(np.float32 if float32 else np.float64)
    there, some, name = cuda.to_device(q), q[:_SAMPLE].astype(np.float64), ", float32" if float32 else ""
    of = in_single if float32 else (lambda driver: driver)
    bodies = robot._checker.bodies.table  # noqa: SLF001 - for the size of the driver for boxes
    n, sizes = len(q), (robot.n_dof, len(robot.tree.joints), len(bodies), BOXES, False)
    expected = robot.forward_kinematics(some)
    bench.rate(f"poses{name}", n, size * 23, lambda: on_gpu.forward_kinematics(there), off(expected), of(poses_of(7)))
    bench.rate(f"Jacobians{name}", n, size * 49, lambda: on_gpu.jacobian(there), off(robot.jacobian(some)), of(jacobians_of(7)))
    for count, word in ((1, "box"), (20, "boxes"), (100, "boxes")):
        world = boxes(count)
        bench.rate(
            f"in_collision, {count} {word}{name}", n, size * 7 + 1, lambda w=world: on_gpu.in_collision(there, w),
            differs(robot, some, world, 1e-3 if float32 else 1e-9), of(overlaps_of(*sizes)),
        )  # fmt: skip


def forces(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Dynamics of motions with random rates."""
    on_gpu, n, sizes = robot.on_gpu(), robot.n_dof, (robot.n_dof, len(robot.tree.joints))
    motion = q, *np.random.default_rng(9).normal(size=(2, *q.shape))
    there, some = tuple(map(cuda.to_device, motion)), tuple(each[:_SAMPLE] for each in motion)
    works = {
        "inverse_dynamics": (8 * 4 * n, 3, inverse_of(*sizes, 2)), "gravity_torque": (8 * 2 * n, 1, gravity_of(*sizes)),
        "mass_matrix": (8 * n * (n + 1), 1, masses_of(*sizes)), "forward_dynamics": (8 * 4 * n, 3, forward_of(*sizes, 2)),
    }  # fmt: skip
    for name, (each, count, driver) in works.items():
        call, expected = getattr(on_gpu, name), getattr(robot, name)(*some[:count])
        bench.rate(name, len(q), each, lambda c=call, k=count: c(*there[:k]), off(expected), driver)
    by_q = robot.inverse_dynamics_derivatives(*some)[0]
    bench.rate(
        "inverse_dynamics_derivatives", len(q), 8 * (3 * n + 2 * n * n), lambda: on_gpu.inverse_dynamics_derivatives(*there)[0],
        off(by_q), derivatives_of(*sizes, 2),
    )  # fmt: skip


def distances(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Distances of boxes, and of any shapes."""
    on_gpu, there = robot.on_gpu(), cuda.to_device(q)
    world = boxes(20)
    bench.rate(
        "signed_distance, 20 boxes", len(q), 64, lambda: on_gpu.signed_distance(there, world),
        off(robot.signed_distance(q[:_SAMPLE], world)),
    )  # fmt: skip
    few = q[: 1 << 16]
    mixed, some = boxes(20), cuda.to_device(few)
    mixed.add("ball", ulna.Sphere(0.1), ulna.pose((0.4, 0.2, 0.5)))
    bench.rate(
        "signed_distance, 20 boxes and a ball", len(few), 64, lambda: on_gpu.signed_distance(some, mixed),
        off(robot.signed_distance(few[:_SAMPLE], mixed)),
    )  # fmt: skip


def clouds(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Collisions beside a cloud of a camera, and the next image."""
    on_gpu, there, n = robot.on_gpu(), cuda.to_device(q), len(q)
    some, world = q[:_SAMPLE], ulna.World()
    images = [_image(k, min(300_000, 100 * n)) for k in range(2)]
    world.add("seen", ulna.PointCloud(images[0][:: max(1, len(images[0]) // 100_000)], 0.004))
    bench.rate(
        "in_collision, cloud of 10^5 points", n, 57, lambda: on_gpu.in_collision(there, world), differs(robot, some, world, 1e-9)
    )
    bench.rate(
        "signed_distance, cloud of 10^5 points", n, 64, lambda: on_gpu.signed_distance(there, world),
        off(robot.signed_distance(some, world)),
    )  # fmt: skip
    ends = q + np.random.default_rng(6).normal(scale=0.2, size=q.shape)
    end, expected = cuda.to_device(ends), robot.edge_in_collision(some, ends[:_SAMPLE], world).in_collision
    bench.rate(
        "edge_in_collision, cloud of 10^5 points", n, 8 * 21 + 9, lambda: on_gpu.edge_in_collision(there, end, world),
        lambda found: float(np.mean(host(found.in_collision) != expected) > 1e-3),
    )  # fmt: skip
    one, order = there[:1], iter(range(1 << 30))

    def next_image() -> Any:
        world.update("seen", images[next(order) % 2])
        return on_gpu.in_collision(one, world)

    bench.rate(
        f"update of a cloud of {len(images[0])} points, and one in_collision", 1, 12 * len(images[0]), next_image,
        lambda found: float(host(found)[0] != robot.in_collision(q[0], world)),
    )  # fmt: skip


def _image(k: int, n: int) -> Any:
    """Points of a bent wall as a camera sees it."""
    y, z = np.meshgrid(np.linspace(-0.8, 0.8, max(2, n // 500)), np.linspace(0.0, 1.1, min(n, 500)))
    return np.stack([0.5 + 0.1 * np.sin(5.0 * y + k), y, z], axis=-1).reshape(-1, 3).astype(np.float32)


def plans(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Short plans, most of them straight, beside the CPU on all cores."""
    on_gpu, world = robot.on_gpu(), boxes(20)
    starts = q[~robot.in_collision(q, world)]
    goals = np.clip(starts + np.random.default_rng(7).normal(scale=0.1, size=starts.shape), robot.lower, robot.upper)
    free = ~robot.edge_in_collision(starts, goals, world).in_collision
    starts, goals = starts[free], goals[free]
    expected = robot.plan_many(starts[:_SAMPLE], goals[:_SAMPLE], world)

    def differing(found: Any) -> float:
        pairs = zip(found[:_SAMPLE], expected, strict=True)
        return float(sum(not np.array_equal(a.path, b.path) or a.effort != b.effort for a, b in pairs))

    for name, planner in (("the GPU", on_gpu), ("the CPU", robot)):
        bench.rate(f"plan_many, straight, {name}", len(starts), 1, lambda p=planner: p.plan_many(starts, goals, world), differing)


def inverse(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Searches, with and without a world; the CPU's forward kinematics verifies and counts the solutions."""
    on_gpu, world, n = robot.on_gpu(), boxes(1), len(q)
    T = on_gpu.forward_kinematics(cuda.to_device(q))

    def missed(found: Any) -> float:
        print(f"{np.mean(found.success):.6%} of {n} solved", flush=True)
        solved = found.success[:_SAMPLE]
        if found.success.mean() < 1.0:
            by_cpu = robot.inverse_kinematics(host(T), world=world).success
            print(f"of {len(solved)} the GPU solves {solved.sum()}, the CPU {by_cpu.sum()}", flush=True)
        return float(np.abs(robot.forward_kinematics(host(found.q)) - host(T))[solved].max())

    each, driver = 8 * (16 + robot.n_dof + 13), searches_of(robot.n_dof)
    bench.rate("inverse_kinematics, 1e-5", n, each, lambda: on_gpu.inverse_kinematics(T), missed, driver)
    bench.rate(
        "inverse_kinematics, 1e-5, clear of 1 box", n, each, lambda: on_gpu.inverse_kinematics(T, world=world), missed, driver
    )


def closed_forms(bench: Bench, panda: ulna.Robot, n: int) -> None:
    """All branches of a UR5, left on the device; and of the Panda, prepared by the CPU."""
    ur5 = ulna.Robot.from_dh(UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6)
    for name, robot, count, samples in (("UR5", ur5, n, 1), ("Panda, 16 places", panda, min(n, 1 << 14), 16)):
        on_gpu = robot.on_gpu()
        T = on_gpu.forward_kinematics(cuda.to_device(robot.random(count, seed=3)))
        expected = robot.all_solutions(host(T), n_samples=samples)

        def same(found: Any, expected: Any = expected) -> float:
            q, real = host(found.q), host(found.real)
            return float("inf") if (real != expected.real).any() else float(np.nanmax(np.abs(q - expected.q)))

        bench.rate(
            f"all_solutions, {name}", count, 8 * 16 + 8 * samples * (8 * robot.n_dof + 3),
            lambda g=on_gpu, t=T, s=samples: g.all_solutions(t, n_samples=s), same, branches_of(),
        )  # fmt: skip


def calls(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """Calls that do not wait, into existing arrays; and small batches, next to the CPU on all cores."""
    on_gpu, world, repeats = robot.on_gpu(), boxes(20), 20 if bench.repeats > 1 else 1
    for n in sorted({min(n, len(q)) for n in (1 << 20, 1000, 100)}, reverse=True):
        part = q[:n]
        there, pose, jacobian = cuda.to_device(part), cuda.device_array((len(part), 4, 4)), cuda.device_array((len(part), 6, 7))
        T = robot.forward_kinematics(part)
        hits, targets = cuda.device_array(len(part), np.bool_), cuda.to_device(T)

        def chain(work: Callable[[], Any]) -> Callable[[], Any]:
            def several() -> Any:
                with on_gpu.checked():
                    for _ in range(repeats):
                        found = work()
                return found

            return several

        works = {
            "poses": (lambda a=there, o=pose: on_gpu.forward_kinematics(a, out=o), lambda a=part: robot.forward_kinematics(a)),
            "Jacobians": (lambda a=there, o=jacobian: on_gpu.jacobian(a, out=o), lambda a=part: robot.jacobian(a)),
            "in_collision, 20 boxes": (
                lambda a=there, o=hits: on_gpu.in_collision(a, world, out=o), lambda a=part: robot.in_collision(a, world),
            ),
        }  # fmt: skip
        for name, (work, on_cpu) in works.items():
            expected = on_cpu()[:_SAMPLE]
            bench.rate(
                f"{name}, calls in a chain, n {n}", repeats * len(part), 1, chain(work),
                lambda found, e=expected: float(np.abs(host(found) * 1.0 - e).max()),
            )  # fmt: skip
            bench.rate(f"{name}, single calls, n {n}", len(part), 1, work, lambda _: 0.0)
            if n <= 1000:
                bench.rate(f"{name}, the CPU, n {n}", len(part), 1, on_cpu, lambda _: 0.0)
        if n <= 1000:
            works = {
                "the GPU": lambda t=targets: on_gpu.inverse_kinematics(t),
                "the CPU": lambda t=T: robot.inverse_kinematics(t),
            }
            for name, work in works.items():
                bench.rate(f"inverse_kinematics, {name}, n {n}", len(part), 1, work, lambda _: 0.0)


def copies(bench: Bench, robot: ulna.Robot, q: Any) -> None:
    """The same from and to NumPy arrays, where the copies dominate."""
    on_gpu = robot.on_gpu()
    bench.rate(
        "poses from and to NumPy arrays", len(q), 8 * 23, lambda: on_gpu.forward_kinematics(q),
        lambda found: float(np.abs(found[:_SAMPLE] - robot.forward_kinematics(q[:_SAMPLE])).max()),
    )  # fmt: skip


def main(arguments: list[str] | None = None) -> None:
    """Measure all, and print JSON at the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--n", type=int, default=1 << 22)
    parser.add_argument("--repeats", type=int, default=11)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    n, panda = options.n, ulna.load("panda")
    bench = Bench(n, options.repeats)
    print(getattr(cuda.get_current_device(), "name", "simulated"), flush=True)
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (n, 7))
    part = q[: 1 << 20]
    methods(bench, panda, q, float32=False)
    methods(bench, panda, q, float32=True)
    forces(bench, panda, q)
    distances(bench, panda, part)
    clouds(bench, panda, part)
    plans(bench, panda, q[: 1 << 14])
    inverse(bench, panda, part)
    closed_forms(bench, panda, min(n, 1 << 21))
    calls(bench, panda, part)
    copies(bench, panda, q)
    text = json.dumps(bench.lines)
    print(text)
    if options.out:
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
