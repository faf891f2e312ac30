import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_imports_go_one_way_only():
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"]
    linted = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert linted.returncode == 0, linted.stdout + linted.stderr
    assert "0 broken" in linted.stdout


def test_import_ulna_loads_neither_compiler_nor_viewer():
    loaded = run("import sys, ulna; print(*sys.modules)").split()
    others = {"xacro", "typer", "rich", "rospy", "rclpy", "dask", "distributed", "zarr", "xarray", "matplotlib"}
    assert not ({"numba", "llvmlite", "viser", "trimesh"} | others) & set(loaded)


def test_loading_a_robot_needs_no_compiler():
    loaded = run("import sys, ulna; ulna.load('panda'); print(*sys.modules)").split()
    assert "numba" not in loaded


def test_every_public_name_has_one_import_path():
    import ulna

    assert sorted(ulna.__all__) == list(ulna.__all__)
    assert all(getattr(ulna, name).__doc__ for name in ulna.__all__)
