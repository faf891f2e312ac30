"""Detects slower kernels: compares their time relative to a NumPy yardstick with stored ratios.

``python -m benchmarks.guard`` measures and compares; ``--write`` stores the new ratios, after an intended change. A ratio is more
reliable than a time, since both calls are interleaved on the same machine. Another processor has other ratios: use the one named
in the file. No test asserts them.

``--against FOLDER`` interleaves this checkout and another one, each in a process of its own, and prints the quartiles of their
time ratio.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from benchmarks.guard_works import ROWS, works
from benchmarks.ratio import ratio
from ulna.bench.timing import Workload, processor_name, time_interleaved

KEPT = Path(__file__).parent / "guard.json"
SLOWER = 1.25  # times the stored ratio: more than the noise of a busy machine
_ROOT = Path(__file__).parents[1]
_TURNS = 41


def measure() -> dict[str, float]:
    """The lower quartile of each work's time relative to the yardstick's."""
    x = np.linspace(0.1, 1.0, ROWS)
    measured = {"yardstick": Workload(lambda _: np.sqrt(x * x + x), range(256)), **works()}
    timings = time_interleaved(measured, passes=_TURNS)
    return {name: ratio(timing, timings["yardstick"])[0] for name, timing in timings.items() if name != "yardstick"}


def measure_against(folder: Path) -> dict[str, tuple[float, float, float]]:
    """The quartiles of this checkout's time relative to another's, for each work, interleaved."""
    with _worker(_ROOT) as here, _worker(folder) as there:
        ours, theirs = _names(here), _names(there)
        names = [name for name in ours if name in theirs]
        shares: dict[str, list[float]] = {name: [] for name in names}
        for turn in range(_TURNS):
            for name in names:
                pair = (here, there) if turn % 2 == 0 else (there, here)
                times = {id(one): _time(one, name) for one in pair}
                shares[name].append(times[id(here)] / times[id(there)])
    return {name: tuple(np.percentile(share, (25, 50, 75))) for name, share in shares.items()}


@contextmanager
def _worker(folder: Path) -> Iterator[subprocess.Popen]:
    """A process that times the works with the ``ulna`` of a checkout."""
    environment = {**os.environ, "PYTHONPATH": str(folder.resolve() / "src"), "ULNA_THREADS": "1"}
    command, pipe = [sys.executable, "-m", "benchmarks.guard_works"], subprocess.PIPE
    with subprocess.Popen(command, cwd=_ROOT, env=environment, stdin=pipe, stdout=pipe, text=True) as process:  # noqa: S603
        try:
            yield process
        finally:
            process.kill()


def _names(worker: subprocess.Popen) -> list[str]:
    return json.loads(worker.stdout.readline() or "[]")  # pyright: ignore[reportOptionalMemberAccess]


def _time(worker: subprocess.Popen, name: str) -> float:
    worker.stdin.write(name + "\n")  # pyright: ignore[reportOptionalMemberAccess]
    worker.stdin.flush()  # pyright: ignore[reportOptionalMemberAccess]
    return float(worker.stdout.readline())  # pyright: ignore[reportOptionalMemberAccess]


def compare(kept: dict[str, float], now: dict[str, float]) -> list[tuple[str, float, float, str]]:
    """For each work the stored ratio, the new one and a word: slower, quicker, new, gone or "" if unchanged."""
    rows = []
    for name in {**kept, **now}:
        old, new = kept.get(name, float("nan")), now.get(name, float("nan"))
        word = "new" if name not in kept else "gone" if name not in now else _word(new / old)
        rows.append((name, old, new, word))
    return rows


def _word(change: float) -> str:
    return "slower" if change > SLOWER else "quicker" if change < 1 / SLOWER else ""


def main() -> None:
    """Measure, compare, print; exit status 1 if anything is slower."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.guard", description=__doc__)
    parser.add_argument("--write", action="store_true", help="keep the new multiples")
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="another checkout, timed in turns with this one")
    options = parser.parse_args()
    if options.against is not None:
        for name, quartiles in measure_against(options.against).items():
            sys.stdout.write(f"{name:32} {'  '.join(f'{share:.3f}' for share in quartiles)}\n")
        return
    now, kept = measure(), json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {"processor": "", "multiples": {}}
    if options.write:
        text = json.dumps({"processor": processor_name(), "multiples": now}, indent=1)
        KEPT.write_text(text + "\n", encoding="utf-8")
    if kept["processor"] != processor_name():
        sys.stdout.write(f"kept on {kept['processor'] or 'no machine yet'}, measured on {processor_name()}\n")
    rows = compare(kept["multiples"], now)
    for name, old, new, word in rows:
        sys.stdout.write(f"{name:32} {old:10.4g} {new:10.4g}  {word}\n")
    sys.exit(any(word == "slower" for *_, word in rows) and not options.write)


if __name__ == "__main__":
    main()
