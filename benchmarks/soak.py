"""Whether ``ulna view`` runs on and on: a tab drags a box around the arm for minutes, and memory and latency are looked at.

``python -m benchmarks.soak --minutes 10`` prints a row for each minute: the server's resident memory, its threads, and the time
from the arrival of a drag to the end of drawing its answer (distances, verdict, colours). The tab is a process of its own that
talks as the page does and draws nothing; so what is measured is the server's part.
"""

import argparse
import math
import multiprocessing
import threading
import time
from pathlib import Path

import msgspec
import numpy as np
import viser
from websockets.sync.client import connect

import ulna

RATE_HZ = 30.0
ROUND_S = 6.0  # the box goes around the arm in this time
_LOOK_S = 0.002


def tab(url: str, seconds: float) -> None:
    """Drag the chosen obstacle around the arm, as a page would."""
    address = url.replace("http", "ws")
    with connect(address, origin=url, subprotocols=[f"viser-v{viser.__version__}"], max_size=None, compression=None) as socket:
        threading.Thread(target=lambda: [None for _ in socket], daemon=True).start()  # read all that comes, as the page does

        def send(kind: str, **content: object) -> None:
            socket.send(msgspec.msgpack.encode({"type": kind, **content}))

        still = {"wxyz": (1.0, 0.0, 0.0, 0.0), "owner": "", "name": "/chosen"}
        camera = {"position": (2.0, 0.0, 1.0), "look_at": (0.0, 0.0, 0.5), "up_direction": (0.0, 0.0, 1.0)}
        lens = {"fov": 0.7, "near": 0.01, "far": 100.0, "image_height": 800, "image_width": 1280}
        send("ViewerCameraMessage", wxyz=still["wxyz"], **camera, **lens)
        send("TransformControlsDragStartMessage", name="/chosen", owner="")
        start = time.monotonic()
        while (now := time.monotonic() - start) < seconds:
            turn = 2 * math.pi * now / ROUND_S
            send("TransformControlsUpdateMessage", position=(0.45 * math.cos(turn), 0.45 * math.sin(turn), 0.5), **still)
            time.sleep(1 / RATE_HZ)
        send("TransformControlsDragEndMessage", name="/chosen", owner="")


def resident_mb() -> float:
    """The memory of this process [MB], as Linux says; NaN elsewhere."""
    if not Path("/proc/self/statm").exists():
        return math.nan
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def watch(view: object, seconds: float) -> np.ndarray:
    """The answer times of so long [s]."""
    found, end = [view.answer_time], time.monotonic() + seconds
    while time.monotonic() < end:
        if view.answer_time != found[-1]:
            found.append(view.answer_time)
        time.sleep(_LOOK_S)
    return np.array(found[1:])


def row(name: str, times: np.ndarray) -> None:
    """Print a line of the table."""
    half, most, worst = (1e3 * np.quantile(times, share) for share in (0.5, 0.99, 1.0)) if len(times) else (math.nan,) * 3
    print(
        f"{name:>8} {resident_mb():8.1f} {threading.active_count():8d} {len(times):8d} {half:8.2f} {most:8.2f} {worst:8.2f}",
        flush=True,
    )


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=int, default=10)
    parser.add_argument("--robot", default="panda")
    arguments = parser.parse_args()
    world = ulna.World()
    world.add("box", ulna.Box((0.15, 0.09, 0.126)), ulna.pose((0.5, 0, 0.21)))
    with ulna.view(ulna.load(arguments.robot), world) as view:
        view.obstacles.form.choose("box")
        time.sleep(2.0)
        print("  minute    MB rss  threads  answers   median      99%    worst   [ms]")
        row("before", np.zeros(0))
        other = multiprocessing.get_context("spawn").Process(
            target=tab, args=(view.url, 60.0 * arguments.minutes + 5), daemon=True
        )
        other.start()
        watch(view, 5.0)  # the tab's start, and the first answer
        for minute in range(1, arguments.minutes + 1):
            row(str(minute), watch(view, 60.0))
        other.join(timeout=30)
        time.sleep(2.0)
        row("closed", np.zeros(0))


if __name__ == "__main__":
    main()
