import subprocess
import sys
from pathlib import Path


def test_nothing_imports_the_demo_and_its_layers_hold():
    code = "from importlinter.cli import lint_imports_command as c; c()"
    config = str(Path(__file__).with_name("layers.toml"))
    linted = subprocess.run([sys.executable, "-c", code, "--config", config], capture_output=True, text=True, check=False)
    assert linted.returncode == 0, linted.stdout + linted.stderr
    assert "0 broken" in linted.stdout
