"""Runs a program text in its own process, with its own cache of machine code."""

import os
import subprocess
import sys
from pathlib import Path

import ulna
from command_fixtures import without_announcements

PACKAGE = Path(ulna.__file__).parent


def run_fresh(source, *, src=PACKAGE.parent, **variables):
    """The lines that a fresh process prints, with only the variables given about where the cache is."""
    kept = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "NUMBA_DISABLE_JIT")}
    environment = {**kept, "PYTHONPATH": str(src), "PYTHONDONTWRITEBYTECODE": "1", **{k: str(v) for k, v in variables.items()}}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", source], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert without_announcements(done.stderr) == ""
    return done.stdout.splitlines()
