"""``make bench-gpu`` runs from beginning to end, so that it need not be tried first where there is a GPU."""

import json
from argparse import ArgumentTypeError

import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from benchmarks.gpu import PARTS, in_order, main
from benchmarks.gpu_lines import GOALS, Bench, OutOfTime
from numba import cuda

if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)

SMALL = "poses", "Jacobians", "in_collision, 20 boxes", "inverse_kinematics, 1e-5", "inverse_kinematics, 1e-5, clear of 1 box"
ALSO_SMALL = "all_solutions, UR5", "signed_distance, 20 boxes", "edge_in_collision, 20 boxes", "inverse_dynamics"


@pytest.fixture(scope="module")
def lines(tmp_path_factory):
    out = tmp_path_factory.mktemp("bench") / "lines.json"
    main(["--n", "2", "--repeats", "1", "--out", str(out)])
    return {line["what"]: line for line in json.loads(out.read_text())}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of kernels as plain Python
def test_every_method_has_its_line_and_is_right(lines):
    assert set(GOALS) < set(lines)
    assert {f"{name}, single calls, n 2" for name in (*SMALL, *ALSO_SMALL)} < set(lines)
    assert all(line["per_second"] > 0.0 for line in lines.values())
    of_gpu = {name: line for name, line in lines.items() if "the CPU" not in name}
    assert all(line["off"] < (1e-6 if "float32" in name else 1e-4) for name, line in of_gpu.items())


def test_the_kernels_of_every_call_on_the_gpu_are_timed(lines):
    of_gpu = {name: line for name, line in lines.items() if "the CPU" not in name and "Panda, 16" not in name}
    assert all(line["kernel_per_second"] > 0.0 for line in of_gpu.values())
    assert set(lines["inverse_kinematics, 1e-5, clear of 1 box"]["kernels"]) == {"searches", "choose", "overlaps"}
    assert all("kernel_of_goal" in lines[name] for name in GOALS)
    assert all("kernel_per_second" not in line for name, line in lines.items() if "the CPU" in name)


def test_what_is_named_comes_first_and_what_there_is_no_time_for_is_said(capsys):
    assert in_order("plans,edges") == ["plans", "edges", *(name for name in PARTS if name not in {"plans", "edges"})]
    with pytest.raises(ArgumentTypeError, match="no such part: unheard-of"):
        in_order("unheard-of")
    main(["--n", "2", "--repeats", "1", "--first", "edges", "--seconds", "-1"])
    said = capsys.readouterr().out
    assert "left out after -1 s: edges; methods; chains;" in said
    with pytest.raises(OutOfTime):
        Bench(2, 1, 0.0).rate("anything", 1, lambda: None)
