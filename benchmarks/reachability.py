"""Times reachability maps: ``python -m benchmarks.reachability [--poses 1e6] [--large 1e8]``.

It maps a UR5, by its closed form, and a Panda, by search. Each runs with one thread, with two, and with two workers of a Dask
cluster on this machine; alone, and among two boxes. "Inside" is the share of the workers' time in the function of a task.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import ulna
from ulna.reachability import reachability_map as module

PORT = 8799
ORIENTATIONS = 64


def main() -> None:
    """Print a row for each map."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reachability", description=__doc__)
    parser.add_argument("--poses", type=float, default=1e6, help="of each map, about")
    parser.add_argument("--large", type=float, default=0.0, help="of one more map of the UR5")
    options = parser.parse_args()
    ur5 = ulna.load("ur5", base="base_link", tip="tool0", meshes="hulls")
    panda, among = ulna.load("panda"), two_boxes()
    print("| arm | world | how | poses | reached, in collision, out of reach | s | poses/s | inside | MB |")
    print("|---|---|---|---|---|---|---|---|---|")
    for robot in (ur5, panda):
        measured(robot, 2e4, None, 2)  # compiles
        measured(robot, 2e4, among, 2)
        for world in (None, among):
            for threads in (1, 2):
                show(measured(robot, options.poses, world, threads))
    with two_workers() as client:
        for robot in (ur5, panda):
            measured(robot, 2e4, None, 2, client)
            show(measured(robot, 4 * options.poses, None, 2, client))
    if options.large:
        show(measured(ur5, options.large, None, 2))


def two_boxes() -> ulna.World:
    """A box in front of the arm, and a table."""
    world = ulna.World()
    world.add("box", ulna.Box((0.3, 0.8, 0.4)), ulna.pose((0.45, 0.0, 0.15), (0.0, 0.0, 0.3)))
    world.add("table", ulna.Box((2.0, 2.0, 0.05)), ulna.pose((0.0, 0.0, -0.1)), touch_links=["panda_link0", "base_link"])
    return world


def measured(robot: ulna.Robot, poses: float, world: ulna.World | None, n: int, client: Any = None) -> tuple:
    """Map about ``poses`` poses, by n threads or by a cluster of n workers; returns the row."""
    kept: dict[str, Any] = {}
    inner = module.run

    def timed(*arguments: Any) -> Any:
        start = time.perf_counter()
        kept["inside"] = inner(*arguments)
        kept["seconds"] = time.perf_counter() - start
        return kept["inside"]

    bounds = module.default_bounds(robot, robot.tip or robot.tree.leaves[0])
    voxel = float((bounds[1] - bounds[0]).prod() * ORIENTATIONS / poses) ** (1 / 3)
    module.run = timed
    try:
        with tempfile.TemporaryDirectory() as folder, ulna.threads(n):
            path = Path(folder) / "map.zarr"
            found = ulna.reachability_map(
                robot, path, voxel=voxel, orientations=ORIENTATIONS, world=world, client=client, max_iterations=400
            )
            summary = found.summary
    finally:
        module.run = inner
    shares = [100 * summary.statuses.get(name, 0) / summary.poses for name in ("solved", "in collision", "unreachable")]
    shares[0] = 100 * summary.reached / summary.poses
    inside = kept["inside"] / n / kept["seconds"]
    memory = largest_memory()
    how = f"{n} Dask workers" if client is not None else f"{n} thread{'s' * (n > 1)}"
    world_name = "-" if world is None else "two boxes"
    return robot.name, world_name, how, summary.poses, shares, kept["seconds"], summary.poses / kept["seconds"], inside, memory


def largest_memory() -> float:
    """The peak memory of this process [MB]; NaN on Windows, which has no ``resource``."""
    try:
        import resource  # noqa: PLC0415 -- Windows lacks it
    except ImportError:
        return float("nan")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def show(row: tuple) -> None:
    """Print a row."""
    name, world, how, poses, shares, seconds, rate, inside, memory = row
    parts = ", ".join(f"{share:.0f} %" for share in shares)
    print(
        f"| {name} | {world} | {how} | {poses:,} | {parts} | {seconds:.1f} | {rate:,.0f} | {100 * inside:.1f} % | {memory:.0f} |",
        flush=True,
    )


@contextmanager
def two_workers() -> Iterator[Any]:
    """The client of a cluster of two processes on the loopback interface."""
    from distributed import Client  # noqa: PLC0415 -- needs the extra ``reach``

    python, address = (sys.executable, "-m"), f"tcp://127.0.0.1:{PORT}"
    scheduler = (*python, "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(PORT), "--no-dashboard")
    worker = (*python, "distributed.cli.dask_worker", address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny")
    nowhere = subprocess.DEVNULL
    started = [
        subprocess.Popen(command, stdout=nowhere, stderr=nowhere)  # noqa: S603 -- this Python's own programs
        for command in (scheduler, worker, worker)
    ]
    try:
        with Client(address, timeout="60s", set_as_default=False) as client:
            client.wait_for_workers(2)
            yield client
    finally:
        for process in started:
            process.terminate()
            process.wait()


if __name__ == "__main__":
    main()
