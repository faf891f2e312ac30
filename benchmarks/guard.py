"""Whether a kernel has become slower: its time as a multiple of a fixed NumPy yardstick's, against the multiple kept here.

``python -m benchmarks.guard`` measures and compares; ``--write`` keeps the new multiples, for a change that is meant. A multiple
says more than a time, for both are taken turn by turn on the same machine, but another processor has other multiples: keep to the
one that is named in the file. No test asserts them.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

import ulna
from benchmarks.ratio import ratio
from ulna.bench.report import WORKLOADS
from ulna.bench.timing import Workload, processor_name, time_interleaved

KEPT = Path(__file__).parent / "guard.json"
SLOWER = 1.25  # times the kept multiple: more than the noise of a busy machine
_ROWS = 1000


def measure() -> dict[str, float]:
    """For each work the lower quartile of its time as a multiple of the yardstick's."""
    panda = ulna.load("panda")
    x = np.linspace(0.1, 1.0, _ROWS)
    works = {"yardstick": Workload(lambda _: np.sqrt(x * x + x), range(256))}
    for make in WORKLOADS.values():
        works |= make(panda, _ROWS)
    timings = time_interleaved(works, passes=41)
    return {name: ratio(timing, timings["yardstick"])[0] for name, timing in timings.items() if name != "yardstick"}


def compare(kept: dict[str, float], now: dict[str, float]) -> list[tuple[str, float, float, str]]:
    """For each work the kept multiple, the new one and a word: slower, quicker, new, gone or "" if it is as it was."""
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
    options = parser.parse_args()
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
