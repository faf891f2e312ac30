"""``ulna bench``: what it prints for people and for programs, and the facts that it gives of the machine."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from benchmarks import first_use
from benchmarks.cold_cache import cold_rows
from typer.testing import CliRunner

from ulna.bench.timing import installed_version, machine_facts
from ulna.cli.app import app
from ulna.errors import UlnaError


def run(*arguments):
    return CliRunner().invoke(app, ["bench", *arguments], catch_exceptions=False)


@pytest.mark.slow
def test_the_figures_of_inverse_kinematics_for_programs():
    answer = json.loads(run("ik", "--n", "10", "--json").stdout)
    assert [row["protocol"] for row in answer["protocols"]] == ["reachable", "A", "B", "unreachable"]
    assert [row["solved_percent"] for row in answer["protocols"]] == [100.0, 100.0, 100.0, 0.0]
    assert answer["tracking"][0]["poses"] == 100
    assert {row["work"] for row in answer["ik"]} == {"inverse_kinematics, one", "inverse_kinematics, 10"}
    assert all(row["lower_ns"] <= row["median_ns"] <= row["upper_ns"] for row in answer["ik"])


@pytest.mark.slow
def test_the_figures_of_kinematics_and_collision_for_people():
    shown = run("fk", "jacobian", "collision").stdout
    for work in ("forward_kinematics, one", "link_poses, 8192", "jacobian, one", "in_collision, one", "check_collision, one"):
        assert work in shown


def test_what_cannot_be_measured_is_named_and_the_rest_is_measured():
    answer = json.loads(run("jacobian", "collision", "--robot", "ur5", "--json").stdout)
    assert answer["jacobian"]
    assert answer["collision"] == []
    assert [(row["robot"], row["subject"]) for row in answer["left_out"]] == [("ur5", "collision")]
    assert "mesh" in answer["left_out"][0]["why"]


def test_an_arm_that_reaches_everywhere_has_no_targets_out_of_reach(tmp_path):
    path = tmp_path / "cart.urdf"
    path.write_text("""<robot name="cart"><link name="a"/><link name="b"/>
      <joint name="j" type="planar"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>""")
    answer = json.loads(run("ik", "--robot", str(path), "--n", "5", "--json").stdout)
    assert [row["protocol"] for row in answer["protocols"]] == ["reachable", "A", "B"]
    assert answer["left_out"][0]["why"] == "it reaches everywhere"


def test_an_unknown_subject_is_refused_with_a_suggestion():
    result = run("jacobain")
    assert result.exit_code == 2
    assert "subject: 'jacobain' is not a subject of the benchmark; did you mean 'jacobian'?" in result.stderr


def test_the_description_of_the_machine_has_no_host_names():
    facts = machine_facts()
    assert facts["numba"] == installed_version("numba")
    assert facts["numpy"] == np.__version__
    assert facts["cores"] >= 1
    assert facts["register_bits"] in (128, 256, 512, None)
    assert set(facts) == {
        "processor",
        "cores",
        "register_bits",
        "machine_code",
        "system",
        "python",
        "ulna",
        "numpy",
        "numba",
        "llvmlite",
    }


@pytest.mark.process
@pytest.mark.compiler
def test_registers_are_those_that_the_code_was_compiled_for():
    code = "from ulna.engine.processors import register_bits; print(register_bits())"
    for variable, expected in ({"NUMBA_DISABLE_JIT": "1"}, "None"), ({"NUMBA_CPU_NAME": "generic"}, "128"):
        done = subprocess.run([sys.executable, "-c", code], env=os.environ | variable, capture_output=True, text=True, check=True)
        assert done.stdout.strip() == expected


@pytest.mark.slow
def test_a_first_use_is_timed_step_by_step():
    rows = first_use.first_use_rows(processes=1)
    assert [row["step"] for row in rows][:2] == ["import ulna", "load the Panda"]
    assert all(row["seconds"] > 0 for row in rows)


def test_a_first_use_ever_has_a_cache_folder_of_its_own(monkeypatch):
    code = "import json, os; path = os.environ['NUMBA_CACHE_DIR']; print(json.dumps({path: len(os.listdir(path))}))"
    monkeypatch.setattr(first_use, "_STEPS", code)
    (row,) = cold_rows()
    assert row["seconds"] == 0  # files in it
    assert row["step"] != os.environ.get("NUMBA_CACHE_DIR")
    assert not os.path.exists(row["step"])  # noqa: PTH110 -- and none is left behind


def test_a_measuring_process_that_fails_says_why(monkeypatch):
    monkeypatch.setattr(first_use, "_STEPS", "raise RuntimeError('no machine code today')")
    with pytest.raises(UlnaError, match="no machine code today"):
        cold_rows()


def test_memory_is_measured_for_each_call(monkeypatch):
    call = (800_000, "random_positions(robot, n, 0)", "(lambda q: [q.copy(), robot.forward_kinematics(q)][1])", "result")
    monkeypatch.setattr(first_use, "_CALLS", {"greedy": call})
    (row,) = first_use.memory_rows()
    assert row["extra_megabytes"] >= 800_000 * 7 * 8 / 2**20 * 0.9


@pytest.mark.skipif(first_use.size_rows() == [], reason="runs from source, without being installed")
@pytest.mark.compiler
def test_the_packages_that_the_core_needs_are_weighed():
    sizes = {row["package"]: row["megabytes"] for row in first_use.size_rows()}
    assert {"numpy", "numba", "llvmlite", "all"} <= set(sizes)
    assert sizes["all"] == pytest.approx(sum(size for name, size in sizes.items() if name != "all"))
