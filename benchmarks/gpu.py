"""Problems a second on a GPU, kept on the device, and each result checked against the CPU: ``make bench-gpu``, a few minutes.

Every figure is the median of repeated launches between two synchronisations, the compilation before them. ``bytes`` is what a
problem must at least read and write, for the share of the memory's speed; registers and local memory are the compiler's.
"""

import argparse
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import ulna
from ulna.engine.gpu import cuda

_REPEATS = 11
_SAMPLE = 2000  # results that the CPU computes again


def boxes(n: int) -> ulna.World:
    """A world of n boxes within the Panda's reach."""
    rng, world = np.random.default_rng(n), ulna.World()
    for k in range(n):
        world.add(f"box {k}", ulna.Box(rng.uniform(0.02, 0.15, 3)), ulna.pose(rng.uniform(-0.8, 0.8, 3), rng.uniform(-3, 3, 3)))
    return world


def seconds(work: Callable[[], Any]) -> float:
    """The median time of a call, whatever it launches included."""
    work()
    cuda.synchronize()
    times = []
    for _ in range(_REPEATS):
        start = time.perf_counter()
        work()
        cuda.synchronize()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def rate(name: str, n: int, each_bytes: int, work: Callable[[], Any], check: Callable[[Any], float]) -> dict[str, Any]:
    """A line of the table: problems a second, bytes a second, and the largest difference from the CPU."""
    worst = check(work())
    took = seconds(work)
    line = {"what": name, "n": n, "per_second": n / took, "bytes_per_second": n * each_bytes / took, "off": worst}
    print(f"{name:42} {n / took:12.4g} /s  {n * each_bytes / took / 1e9:8.1f} GB/s  off by {worst:.2g}", flush=True)
    return line


def main() -> None:
    """Measure all, and print JSON at the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--n", type=int, default=1 << 22)
    n = parser.parse_args().n
    panda = ulna.load("panda")
    on_gpu = panda.on_gpu()
    print(cuda.get_current_device().name, flush=True)
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (n, 7))
    there, some = cuda.to_device(q), slice(0, _SAMPLE)

    def off(expected: Any) -> Callable[[Any], float]:
        return lambda found: float(np.abs(found[some].copy_to_host() - expected).max())

    def differs(world: ulna.World) -> Callable[[Any], float]:
        far = np.abs(panda.signed_distance(q[some], world)) > 1e-9
        expected = panda.in_collision(q[some], world)
        return lambda found: float(np.count_nonzero((found[some].copy_to_host() != expected) & far))

    lines = [
        rate("poses", n, 8 * (7 + 16), lambda: on_gpu.forward_kinematics(there), off(panda.forward_kinematics(q[some]))),
        rate("Jacobians", n, 8 * (7 + 42), lambda: on_gpu.jacobian(there), off(panda.jacobian(q[some]))),
    ]
    for n_boxes in (1, 20, 100):
        world = boxes(n_boxes)
        lines.append(rate(f"in_collision, {n_boxes} boxes", n, 57, lambda w=world: on_gpu.in_collision(there, w), differs(world)))
    part = there[: 1 << 20]
    world = boxes(20)
    expected = panda.signed_distance(q[some], world)
    lines.append(rate("signed_distance, 20 boxes", len(part), 64, lambda: on_gpu.signed_distance(part, world), off(expected)))
    T = on_gpu.forward_kinematics(part)
    found = on_gpu.inverse_kinematics(T)
    reached = panda.forward_kinematics(found.q[some].copy_to_host())
    print(f"inverse kinematics: {found.success.mean():.6%} of {len(part)} solved", flush=True)
    lines.append(
        rate(
            "inverse_kinematics, 1e-5", len(part), 8 * (16 + 7 + 13), lambda: on_gpu.inverse_kinematics(T),
            lambda _: float(np.abs(reached - T[some].copy_to_host()).max()),
        )
    )  # fmt: skip
    start = time.perf_counter()
    on_gpu.forward_kinematics(q)
    print(f"poses from and to NumPy arrays: {n / (time.perf_counter() - start):.4g} /s")
    print(json.dumps(lines))


if __name__ == "__main__":
    main()
