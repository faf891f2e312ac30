"""``ulna.torch`` with ``robot.on_gpu()``, in numba-cuda's simulator; ``test_torch.py`` does it on a GPU where there is one."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="PyTorch is in an environment of its own: make test-learning")
if importlib.util.find_spec("numba_cuda") is None:
    pytest.skip("numba-cuda is missing: make test-learning installs it", allow_module_level=True)


def test_a_robot_on_a_gpu_gives_tensors_the_values_and_gradients_of_the_cpu():
    environment = os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    program = [sys.executable, str(Path(__file__).parent / "simulated_gpu.py")]
    done = subprocess.run(program, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert max(seen["off"]) < 1e-12
    assert seen["launched"] == ["_jacobian", "_pose", "distances"]
