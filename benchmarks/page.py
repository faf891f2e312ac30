"""Updates of a cloud on the page of ``ulna view``, ten a second: ``python -m benchmarks.page``. What takes how long, each apart.

Chromium without a GPU, once with every WebGL call that draws left out, and once as it is: an update counts when its points reach
WebGL. Then the server alone: a program on the same machine takes what the page would, and discards it.
"""

import argparse
import asyncio
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import viser
import websockets

import ulna
from benchmarks.markdown import table

SIZE = {"width": 1280, "height": 800}
BYTES = 12  # of a point on its way to the page
# Counts the arrays of so many bytes that reach WebGL.
COUNTED = """
window.uploads = 0;
for (const name of ["bufferData", "bufferSubData"]) {
  const upload = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...given) {
    if (given.some((one) => one && one.byteLength >= BYTES)) window.uploads += 1;
    return upload.apply(this, given);
  };
}
"""
NOT_DRAWN = """
for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced", "clear"])
  WebGL2RenderingContext.prototype[name] = () => {};
"""
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.page", description=__doc__)
    parser.add_argument("--points", type=int, action="append", help="repeatable; 30,000 and 300,000 unless given")
    parser.add_argument("--rate", type=float, default=10.0, help="updates a second")
    parser.add_argument("--seconds", type=float, default=10.0, help="of each measurement")
    parser.add_argument("--discard", metavar="PORT", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.discard:
        asyncio.run(discard(options.discard))
        return
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    for n in options.points or (30_000, 300_000):
        for row in page_rows(n, options.rate, options.seconds):
            print(f"\n{table([row])}", flush=True)


def page_rows(n: int, rate: float, seconds: float) -> Iterator[dict]:
    """The updates of n points that arrive: at a program, in a browser that draws nothing, in one that draws."""
    rng, world = np.random.default_rng(0), ulna.World()
    places = rng.uniform((0.5, -1, -0.5), (1.5, 1, 0), (4, n, 3)).astype(np.float32)
    clouds = [ulna.PointCloud(points, 0.002) for points in places]
    world.add("seen", clouds[0])
    with ulna.view(ulna.load("panda"), world) as view:
        for who, opened in (
            ("Chromium, nothing drawn", browser(view, n, NOT_DRAWN)),  # a tab first: it begins what is to be compiled
            ("Chromium, drawn by software", browser(view, n, "")),
            ("a program that discards", program(view)),
        ):
            with opened as (arrived, used):
                while not (view.ready and arrived()):
                    time.sleep(0.5)
                time.sleep(3.0)
                first, before, own, began, k = arrived(), used(), time.process_time(), time.perf_counter(), 0
                while time.perf_counter() < began + seconds:
                    k += 1
                    world.update("seen", clouds[k % 4])
                    time.sleep(max(0.0, began + k / rate - time.perf_counter()))
                own, spent, there = time.process_time() - own, used() - before, arrived() - first
                took = time.perf_counter() - began
                yield {
                    "who": who, "points": n, "updates_a_second": k / took, "arrived_a_second": there / took,
                    "server_ms": 1e3 * own / k, "other_processes_ms": 1e3 * spent / max(there, 1),
                }  # fmt: skip


@contextmanager
def program(view) -> Iterator[tuple[Callable[[], int], Callable[[], float]]]:
    """A program that takes the page's messages and discards them: how many clouds it has, and its processor time [s]."""
    command = [sys.executable, "-m", "benchmarks.page", "--discard", view.url.rstrip("/").rsplit(":", 1)[1]]
    taker = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)  # noqa: S603 - this very program
    asked: Any = taker.stdin
    told: Any = taker.stdout

    def ask() -> tuple[int, float]:
        asked.write("?\n")
        asked.flush()
        return tuple(json.loads(told.readline()))

    try:
        yield lambda: ask()[0], lambda: ask()[1]
    finally:
        taker.kill()
        taker.wait()


async def discard(port: int) -> None:
    """Take the messages of a page; after each line of input print how many had a cloud, and the processor time [s]."""
    clouds, loop = 0, asyncio.get_running_loop()

    async def tell() -> None:
        while await loop.run_in_executor(None, sys.stdin.readline):
            print(json.dumps([clouds, time.process_time()]), flush=True)

    telling = loop.create_task(tell())
    protocol = [websockets.Subprotocol(f"viser-v{viser.__version__}")]
    address = f"ws://127.0.0.1:{port}"
    endless: dict[str, Any] = {"max_size": None, "open_timeout": None, "ping_interval": None}
    async with websockets.connect(address, subprotocols=protocol, compression=None, **endless) as page:
        async for message in page:
            clouds += len(message) > 1e5
    await telling


@contextmanager
def browser(view, n: int, script: str) -> Iterator[tuple[Callable[[], int], Callable[[], float]]]:
    """A tab: how many clouds have reached its WebGL, and the processor time of all the browser's processes [s]."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    from browser import FLAGS  # noqa: PLC0415 -- of the tests

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        page = chromium.new_page(viewport=SIZE)
        page.add_init_script(COUNTED.replace("BYTES", str(BYTES * n)) + script)
        page.goto(view.url)
        try:
            yield lambda: page.evaluate("window.uploads"), children_time
        finally:
            chromium.close()


def children_time() -> float:
    """The processor time of all the processes that this one has started, and of those that they have [s]."""
    parents, times = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:  # it has ended
            continue
        parents[int(folder.name)], times[int(folder.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    total = 0
    for process, ticks in times.items():
        above = parents[process]
        while above in parents and above != os.getpid():
            above = parents[above]
        total += ticks if above == os.getpid() else 0
    return total / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
