"""``make bench-gpu`` runs from beginning to end, so that it need not be tried first where there is a GPU."""

import json

import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from benchmarks.gpu import GOALS, main
from numba import cuda

if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of kernels as plain Python
def test_every_method_has_its_line_and_is_right(tmp_path):
    main(["--n", "2", "--repeats", "1", "--out", str(tmp_path / "lines.json")])
    lines = {line["what"]: line for line in json.loads((tmp_path / "lines.json").read_text())}
    assert set(GOALS) < set(lines)
    assert all(line["per_second"] > 0.0 for line in lines.values())
    assert all(line["off"] < (1e-6 if "float32" in name else 1e-4) for name, line in lines.items())
