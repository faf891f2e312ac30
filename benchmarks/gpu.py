"""Measures problems per second on a GPU, and compares results with the CPU: ``make bench-gpu``, a few minutes.

Every figure is the median of repeated calls between two synchronizations, without compilation. The kernel's figure is the time
between two events of the device around each launch, added up. ``of_memory`` is the share of the memory's speed, by the minimum
that a problem reads and writes. Registers and local memory are the compiler's figures. Threads at once are those that a
multiprocessor can hold, by registers and shared memory. The memory bounds a method if its share is near 1. Otherwise the units
for float64 (or float32) bound it, or the latency of too few threads.

ARGS="--n 65536 --repeats 3" measures less. ``--first edges,clouds`` measures these parts before all others, and ``--seconds 300``
begins no figure after that time, and lists what it left out. ``--out FILE`` writes the lines as JSON.
"""

import argparse
import json
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import ulna
from benchmarks.gpu_calls import calls, small_batches
from benchmarks.gpu_lines import (
    MANY,
    SAMPLE,
    Bench,
    OutOfTime,
    boxes,
    differing,
    differing_edges,
    host,
    off,
    reaching,
    same_branches,
)
from ulna.gpu.device import cuda

UR5 = [
    (0, 0.089159, np.pi / 2, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0),
    (0, 0.10915, np.pi / 2, 0), (0, 0.09465, -np.pi / 2, 0), (0, 0.0823, 0, 0),
]  # fmt: skip


class Case(NamedTuple):
    """What all parts measure: a Panda, random configurations of it, and a UR5."""

    panda: ulna.Robot
    q: Any
    ur5: ulna.Robot

    @property
    def many(self) -> Any:
        """The first configurations, at most ``MANY``."""
        return self.q[:MANY]


def methods(bench: Bench, case: Case, *, float32: bool = False) -> None:
    """Poses, Jacobians and collisions, in float64 or float32."""
    robot, on_gpu, size = case.panda, case.panda.on_gpu(float32=float32), 4 if float32 else 8
    q = case.q.astype(np.float32 if float32 else np.float64)
    there, some, name, n = cuda.to_device(q), q[:SAMPLE].astype(np.float64), ", float32" if float32 else "", len(q)
    poses, jacobians = off(robot.forward_kinematics(some)), off(robot.jacobian(some))
    bench.rate(f"poses{name}", n, lambda: on_gpu.forward_kinematics(there), poses, each_bytes=23 * size)
    bench.rate(f"Jacobians{name}", n, lambda: on_gpu.jacobian(there), jacobians, each_bytes=49 * size)
    many = there[:MANY]
    links = off(robot.link_poses(some))
    each = (7 + 16 * len(robot.link_names)) * size
    bench.rate(f"poses of all links{name}", len(many), lambda: on_gpu.link_poses(many), links, each_bytes=each)
    for count, word in ((1, "box"), (20, "boxes"), (100, "boxes")):
        world = boxes(count)
        check = differing(robot, some, world, 1e-3 if float32 else 1e-9)
        bench.rate(f"in_collision, {count} {word}{name}", n, lambda w=world: on_gpu.in_collision(there, w), check)


def in_float32(bench: Bench, case: Case) -> None:
    """The same in float32."""
    methods(bench, case, float32=True)


def forces(bench: Bench, case: Case) -> None:
    """Dynamics of motions with random rates."""
    robot, q, on_gpu = case.panda, case.q, case.panda.on_gpu()
    n, motion = robot.n_dof, (q, *np.random.default_rng(9).normal(size=(2, *q.shape)))
    there, some = tuple(map(cuda.to_device, motion)), tuple(each[:SAMPLE] for each in motion)
    works = {
        "inverse_dynamics": (4 * n, 3), "gravity_torque": (2 * n, 1), "mass_matrix": (n * (n + 1), 1),
        "forward_dynamics": (4 * n, 3),
    }  # fmt: skip
    for name, (numbers, count) in works.items():
        call, check = getattr(on_gpu, name), off(getattr(robot, name)(*some[:count]))
        bench.rate(name, len(q), lambda c=call, k=count: c(*there[:k]), check, each_bytes=8 * numbers)
    by_q, by_rate = robot.inverse_dynamics_derivatives(*some)

    def check_both(found: Any) -> dict[str, float]:
        return {"off": max(off(by_q)(found[0])["off"], off(by_rate)(found[1])["off"])}

    name = "inverse_dynamics_derivatives"
    bench.rate(name, len(q), lambda: on_gpu.inverse_dynamics_derivatives(*there), check_both, each_bytes=8 * (3 * n + 2 * n * n))


def distances(bench: Bench, case: Case) -> None:
    """Distances of boxes, and of boxes and a ball."""
    robot, on_gpu, q = case.panda, case.panda.on_gpu(), case.many
    mixed = boxes(20)
    mixed.add("ball", ulna.Sphere(0.1), ulna.pose((0.4, 0.2, 0.5)))
    there = cuda.to_device(q)
    for name, world in {"20 boxes": boxes(20), "20 boxes and a ball": mixed}.items():
        check = off(robot.signed_distance(q[:SAMPLE], world))
        bench.rate(f"signed_distance, {name}", len(q), lambda w=world: on_gpu.signed_distance(there, w), check)


def edges(bench: Bench, case: Case) -> None:
    """Edges whose joints move by 0.2 rad (standard deviation)."""
    for count, name in ((1, "1 box"), (20, "20 boxes")):
        _edges(bench, case, boxes(count), name)


def _edges(bench: Bench, case: Case, world: ulna.World, name: str) -> None:
    robot, on_gpu, q = case.panda, case.panda.on_gpu(), case.many
    ends = q + np.random.default_rng(6).normal(scale=0.2, size=q.shape)
    start, end, check = *map(cuda.to_device, (q, ends)), robot.edge_in_collision(q[:SAMPLE], ends[:SAMPLE], world)
    name = f"edge_in_collision, {name}"
    bench.rate(name, len(q), lambda: on_gpu.edge_in_collision(start, end, world), differing_edges(check))


def clouds(bench: Bench, case: Case) -> None:
    """Collisions beside a cloud of a camera, and the next image."""
    robot, on_gpu, q = case.panda, case.panda.on_gpu(), case.many
    n, some, there, world = len(q), q[:SAMPLE], cuda.to_device(q), ulna.World()
    images = [_image(k, min(300_000, 100 * n)) for k in range(2)]
    world.add("seen", ulna.PointCloud(images[0][:: max(1, len(images[0]) // 100_000)], 0.004))
    name = "cloud of 10^5 points"
    bench.rate(f"in_collision, {name}", n, lambda: on_gpu.in_collision(there, world), differing(robot, some, world))
    check = off(robot.signed_distance(some, world))
    bench.rate(f"signed_distance, {name}", n, lambda: on_gpu.signed_distance(there, world), check)
    _edges(bench, case, world, name)
    one, order = there[:1], iter(range(1 << 30))

    def next_image() -> Any:
        world.update("seen", images[next(order) % 2])
        return on_gpu.in_collision(one, world)

    def differs(found: Any) -> dict[str, float]:
        return {"off": float(host(found)[0] != robot.in_collision(q[0], world))}

    bench.rate(f"update of a cloud of {len(images[0])} points, and one in_collision", 1, next_image, differs)


def _image(k: int, n: int) -> Any:
    """Points of a bent wall as a camera sees it."""
    y, z = np.meshgrid(np.linspace(-0.8, 0.8, max(2, n // 500)), np.linspace(0.0, 1.1, min(n, 500)))
    return np.stack([0.5 + 0.1 * np.sin(5.0 * y + k), y, z], axis=-1).reshape(-1, 3).astype(np.float32)


def plans(bench: Bench, case: Case) -> None:
    """Short plans, most of them straight, beside the CPU on all cores."""
    robot, world, q = case.panda, boxes(20), case.q[: 1 << 14]
    starts = q[~robot.in_collision(q, world)]
    goals = np.clip(starts + np.random.default_rng(7).normal(scale=0.1, size=starts.shape), robot.lower, robot.upper)
    free = ~robot.edge_in_collision(starts, goals, world).in_collision
    starts, goals = starts[free], goals[free]
    expected = robot.plan_many(starts[:SAMPLE], goals[:SAMPLE], world)

    def other_plans(found: Any) -> dict[str, float]:
        pairs = zip(found[:SAMPLE], expected, strict=True)
        return {"off": float(sum(not np.array_equal(a.path, b.path) or a.effort != b.effort for a, b in pairs))}

    for name, planner in (("the GPU", robot.on_gpu()), ("the CPU", robot)):
        check = other_plans if planner is not robot else None
        bench.rate(f"plan_many, straight, {name}", len(starts), lambda p=planner: p.plan_many(starts, goals, world), check)


def inverse(bench: Bench, case: Case) -> None:
    """Searches, with and without a world, and with a smaller budget."""
    robot, on_gpu, q = case.panda, case.panda.on_gpu(), case.many
    T = on_gpu.forward_kinematics(cuda.to_device(q))
    world, name = boxes(1), "inverse_kinematics, 1e-5"
    clear: dict[str, Any] = {"world": world}
    ways = {"": {}, ", clear of 1 box": clear, ", clear of 1 box, max_iterations=1280": {**clear, "max_iterations": 1280}}
    for more, options in ways.items():
        check = reaching(robot, T, **options)
        bench.rate(name + more, len(q), lambda o=options: on_gpu.inverse_kinematics(T, **o), check)


def closed_forms(bench: Bench, case: Case) -> None:
    """All branches of a UR5, left on the device; and of the Panda, prepared by the CPU."""
    ways = (("UR5", case.ur5, 1 << 21, 1), ("Panda, 16 places", case.panda, 1 << 14, 16))
    for name, robot, most, samples in ways:
        on_gpu, n = robot.on_gpu(), min(bench.n, most)
        T = on_gpu.forward_kinematics(cuda.to_device(robot.random(n, seed=3)))
        check = same_branches(robot.all_solutions(host(T), n_samples=samples))
        each = 8 * 16 + 8 * (8 * robot.n_dof + 3) if robot is case.ur5 else 0
        bench.rate(
            f"all_solutions, {name}", n, lambda g=on_gpu, t=T, s=samples: g.all_solutions(t, n_samples=s), check, each_bytes=each
        )


def in_chains(bench: Bench, case: Case) -> None:
    """Calls of ``MANY`` problems, beside their kernels."""
    calls(bench, case.panda, case.many)


def small(bench: Bench, case: Case) -> None:
    """Batches of 100 and 1,000 problems, beside the CPU on all cores."""
    small_batches(bench, case.panda, case.ur5, case.q)


def copies(bench: Bench, case: Case) -> None:
    """From and to NumPy arrays, where the copies dominate."""
    on_gpu, check = case.panda.on_gpu(), off(case.panda.forward_kinematics(case.q[:SAMPLE]))
    bench.rate("poses from and to NumPy arrays", len(case.q), lambda: on_gpu.forward_kinematics(case.q), check)


PARTS: dict[str, Callable[[Bench, Case], None]] = {
    "methods": methods, "chains": in_chains, "inverse": inverse, "edges": edges, "solutions": closed_forms, "clouds": clouds,
    "distances": distances, "forces": forces, "small": small, "plans": plans, "float32": in_float32, "copies": copies,
}  # fmt: skip


def in_order(first: str) -> list[str]:
    """All parts, those of a list separated by commas first.

    Raises:
        argparse.ArgumentTypeError: There is no such part.
    """
    named = [name for name in first.split(",") if name]
    unknown = set(named) - set(PARTS)
    if unknown:
        raise argparse.ArgumentTypeError(f"no such part: {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    return [*named, *(name for name in PARTS if name not in named)]


def measure(bench: Bench, names: list[str], out: Path | None) -> tuple[list[str], list[str]]:
    """Measure parts, one after the other; the parts left out in whole or in part, and those that failed."""
    panda = ulna.load("panda")
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (bench.n, 7))
    case, left_out, failed = Case(panda, q, ulna.Robot.from_dh(UR5, convention="standard", limits=[(-np.pi, np.pi)] * 6)), [], []
    for name in names:
        start = time.monotonic()
        try:
            bench.refuse_late(name)
            PARTS[name](bench, case)
        except OutOfTime as first:
            left_out.append(name if str(first) == name else f"{name} (from '{first}' on)")
        except Exception:  # noqa: BLE001 - on a borrowed card the other figures are still wanted
            failed.append(name)
            traceback.print_exc()
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
        if out:
            out.write_text(json.dumps(bench.lines), encoding="utf-8")
    return left_out, failed


def main(arguments: list[str] | None = None) -> None:
    """Measure all, and print JSON at the end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=1 << 22)
    parser.add_argument("--repeats", type=int, default=11)
    parser.add_argument("--first", type=in_order, default=list(PARTS), metavar="PARTS", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="no figure begins later")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    print(getattr(cuda.get_current_device(), "name", "simulated"), flush=True)
    bench = Bench(options.n, options.repeats, time.monotonic() + options.seconds)
    left_out, failed = measure(bench, options.first, options.out)
    print(json.dumps(bench.lines))
    if left_out:
        print(f"left out after {options.seconds:.0f} s: {'; '.join(left_out)}")
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
