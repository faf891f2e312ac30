"""The example that learns, the page about it, and what a program that does not learn loads."""

import runpy
import subprocess
import sys

import pytest

pytest.importorskip("torch", reason="PyTorch is in an environment of its own: make test-learning")
pytest.importorskip("jax", reason="JAX is in an environment of its own: make test-learning")

import jax
import torch

from doc_pages import ROOT, blocks


@pytest.fixture(autouse=True)
def _settings_are_put_back():
    yield
    jax.config.update("jax_enable_x64", False)
    torch.set_default_dtype(torch.float32)


def test_the_example_runs_and_its_assertions_hold(capsys):
    runpy.run_path(str(ROOT / "examples" / "16_learn_ik.py"), run_name="__main__")
    assert "a median error of" in capsys.readouterr().out


def test_the_code_of_the_page_runs(capsys):
    *code, on_gpu = [block.text for block in blocks(ROOT / "docs" / "learning.md")]
    assert len(code) == 2
    compile(on_gpu, "learning.md", "exec")  # it needs a GPU
    seen = {}
    for text in code:
        exec(text, seen)  # noqa: S102 - our own page
    assert capsys.readouterr().out == "torch.Size([256, 7])\n"
    assert seen["slopes"].shape == (256, 7)


def test_a_pose_of_numpy_loads_neither_library():
    code = "import sys, ulna; robot = ulna.load('panda'); robot.jacobian(robot.home); print({'torch', 'jax'} & set(sys.modules))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown == "set()\n"
