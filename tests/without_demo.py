"""Copies the repository without the demo, hw2 and their tests, and runs tests there.

Example: python tests/without_demo.py -n auto tests/cli tests/robot. PYTHONPATH determines which ``ulna`` runs; nothing is
installed.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("src", "tests", "docs", "examples", "benchmarks")
FILES = ("pyproject.toml", "conftest.py", "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "Makefile")
GUEST = ("src/ulna/demo", "tests/demo")  # and hw2, which is not copied
RECURSION = "--ignore=tests/architecture/test_without_demo.py"


def copy_without_demo(folder: Path) -> None:
    """Copy the repository into a folder, without the demo."""

    def left_out(path, names):
        place = Path(path).relative_to(ROOT)
        return [name for name in names if name == "__pycache__" or (place / name).as_posix() in GUEST]

    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, ignore=left_out)
    for name in FILES:
        shutil.copy(ROOT / name, folder)


def run_without_demo(*arguments: str) -> subprocess.CompletedProcess:
    """Run pytest with arguments in such a copy."""
    with TemporaryDirectory() as folder:
        copy_without_demo(Path(folder))
        variables = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
        environment = {**variables, "PYTHONPATH": str(Path(folder) / "src")}
        command = [sys.executable, "-m", "pytest", RECURSION, *arguments]
        return subprocess.run(command, cwd=folder, env=environment, check=False)


if __name__ == "__main__":
    sys.exit(run_without_demo(*sys.argv[1:]).returncode)
