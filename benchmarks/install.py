"""Installs the peers one by one, if installing all at once fails; lists those that are unavailable here."""

import subprocess
import sys
import tomllib
from pathlib import Path


def main() -> None:
    """Install each requirement of the group ``bench``."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    for requirement in project["dependency-groups"]["bench"]:
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", requirement]
        done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 -- named by the project
        if done.returncode:
            sys.stderr.write(f"{requirement}: {(done.stderr.strip().splitlines() or ['pip failed'])[-1]}\n")


if __name__ == "__main__":
    main()
