"""Tests, measures and compares on a machine with a GPU that is there for minutes only: ``make gpu``.

In this order: the tests of ``tests/gpu/device``, the figures of ``benchmarks.gpu``, and the peers. ``--first`` names the parts of
the figures that come first: what has changed. ``--seconds`` is the budget for all. The tests get at most ``TESTS`` of it, the
peers keep ``PEERS``, and the figures take the rest. Each step says what it left out.

All output goes to ``--out``, a folder: tests.txt, figures.txt, figures.json and peers.txt. Where nothing can be installed,
``PYTHONPATH=src python -m benchmarks.gpu_session`` runs the checkout as it is, with what is there.
"""

import argparse
import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.gpu import in_order

TESTS, PEERS = 0.4, 0.1  # shares of the budget
_LATE = 30.0  # [s]: how long the last figure may take after the budget of the figures
_MOST_PROCESSES = 8


class Step:
    """A program that runs within a time, and whose output is shown and kept."""

    def __init__(self, name: str, out: Path) -> None:
        self.name, self._file = name, out / f"{name}.txt"

    def run(self, arguments: list[str], seconds: float) -> str:
        """Run a Python program; what became of it, as a sentence."""
        start = time.monotonic()
        with self._file.open("w", encoding="utf-8") as file:
            program = subprocess.Popen(  # noqa: S603
                [sys.executable, *arguments], stdout=file, stderr=subprocess.STDOUT, start_new_session=True
            )
            try:
                code = program.wait(timeout=max(1.0, seconds))
            except subprocess.TimeoutExpired:
                os.killpg(program.pid, signal.SIGTERM)  # with the processes that it has started
                program.wait()
                code = None
        print(self._file.read_text(encoding="utf-8"), flush=True)
        ended = "stopped" if code is None else "passed" if code == 0 else f"failed with code {code}"
        return f"{self.name}: {ended} after {time.monotonic() - start:.0f} s"


def has(module: str) -> bool:
    """Whether a module is installed."""
    return importlib.util.find_spec(module) is not None


def test_arguments() -> list[str]:
    """The tests, in parallel where pytest can do that; a warning of another library's is no error on an unknown machine."""
    processes = min(_MOST_PROCESSES, os.cpu_count() or 1)
    parallel = ["-n", str(processes)] if has("xdist") else []
    return ["-m", "pytest", "-q", "tests/gpu/device", "-o", "filterwarnings=default", "-p", "no:cacheprovider", *parallel]


def figure_arguments(options: argparse.Namespace, seconds: float) -> list[str]:
    """The figures, what has changed first."""
    sizes = ["--n", str(options.n), "--repeats", str(options.repeats)]
    order = ["--first", options.first, "--seconds", f"{seconds:.0f}", "--out", str(options.out / "figures.json")]
    return ["-m", "benchmarks.gpu", *sizes, *order]


def run(options: argparse.Namespace) -> list[str]:
    """Run the three steps within the budget; what became of each."""
    end, out, said = time.monotonic() + options.seconds, options.out, []
    out.mkdir(parents=True, exist_ok=True)
    if has("pytest") and not options.without_tests:
        said.append(Step("tests", out).run(test_arguments(), TESTS * options.seconds))
    else:
        said.append("tests: left out" if options.without_tests else "tests: left out, pytest is not installed")
    for_figures = end - time.monotonic() - PEERS * options.seconds
    said.append(Step("figures", out).run(figure_arguments(options, max(0.0, for_figures - _LATE)), for_figures))
    said.append(Step("peers", out).run(["-m", "benchmarks.gpu_peers"], end - time.monotonic()))
    missing = [name for name in ("frax", "pytorch_kinematics") if not has(name)]
    return [*said, f"not installed: {', '.join(missing)}"] if missing else said


def _known(first: str) -> str:
    """The parts to measure first; refuses a wrong name before anything runs."""
    in_order(first)
    return first


def main(arguments: list[str] | None = None) -> None:
    """Run all steps, and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--first", type=_known, default="", metavar="PARTS", help="parts of benchmarks.gpu to measure first, with commas"
    )
    parser.add_argument("--seconds", type=float, default=480.0, help="the budget for all")
    parser.add_argument("--n", type=int, default=1 << 22)
    parser.add_argument("--repeats", type=int, default=11)
    parser.add_argument("--without-tests", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("build/gpu"))
    options = parser.parse_args(arguments)
    said = run(options)
    print("\n".join(said))
    if any("failed" in each for each in said):
        sys.exit(1)


if __name__ == "__main__":
    main()
